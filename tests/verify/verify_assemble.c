/* verify.assemble: manufactured solutions with every term and boundary type, observed order in 1, 2
 * and 3 dimensions; exact nodal values of one-dimensional upwinding. */
#include <math.h>

#include "manufactured.h"

/* Which sides are not Dirichlet: a boundary of each type and one of all. */
typedef struct {
  const char *name;
  sct_condition left, right, top;
} walls;

static const walls WALLS[] = {
    {"dirichlet", SCT_DIRICHLET, SCT_DIRICHLET, SCT_DIRICHLET},
    {"neumann", SCT_DIRICHLET, SCT_NEUMANN, SCT_NEUMANN},
    {"robin", SCT_ROBIN, SCT_ROBIN, SCT_ROBIN},
    {"mixed", SCT_NEUMANN, SCT_ROBIN, SCT_DIRICHLET},
};
enum { DIRICHLET, NEUMANN, ROBIN, MIXED };

static void paint(manufactured *m, const walls *w) {
  manufactured_side(m, SCT_SIDE_RIGHT, w->right);
  manufactured_side(m, SCT_SIDE_LEFT, w->left);
  if (m->f->cloud.dim > 1) manufactured_side(m, SCT_SIDE_TOP, w->top);
}

static double steady_error(int dim, int64_t cells, const sct_operator *op, double jitter,
                           uint64_t seed, const walls *w) {
  fixture f = fixture_unit(dim, cells, jitter, seed, op);
  manufactured m = manufactured_new(&f, 0);
  paint(&m, w);
  const double error = manufactured_steady(&m);
  manufactured_free(&m);
  fixture_clear(&f);
  return error;
}

typedef struct {
  const char *scheme;
  int degree;
  double jitter;
  int walls;
  double order, error; /* least observed order, largest error on the finest mesh */
} expectation;

static const int64_t MESH[][3] = {{0}, {20, 40, 80}, {10, 20, 40}, {6, 10, 14}};

static const expectation expectations[] = {
    {"mps", 2, 0.0, DIRICHLET, 1.8, 1e-3}, {"ps", 2, 0.0, DIRICHLET, 1.8, 1e-3},
    {"ips", 2, 0.0, DIRICHLET, 1.8, 1e-3}, {"ips", 2, 0.3, DIRICHLET, -9, 2e-2},
    {"ipsn", 2, 0.3, DIRICHLET, -9, 2e-2}, {"ips", 2, 0.0, NEUMANN, 0.8, 2e-2},
    {"ips", 2, 0.0, ROBIN, 0.8, 2e-2},     {"ips", 2, 0.0, MIXED, 0.8, 2e-2},
    {"lsmps", 2, 0.0, MIXED, 1.8, 1e-3},   {"lsmps", 2, 0.3, DIRICHLET, 1.5, 1e-3},
    {"lsmps", 2, 0.3, NEUMANN, 1.5, 2e-3}, {"lsmps", 2, 0.3, ROBIN, 1.5, 2e-3},
    {"lsmps", 2, 0.3, MIXED, 1.5, 2e-3},   {"lsmps", 3, 0.3, DIRICHLET, 1.6, 3e-4},
    {"lsmps", 3, 0.3, NEUMANN, 1.6, 1e-3}, {"lsmps", 3, 0.3, ROBIN, 1.6, 1e-3},
    {"lsmps", 3, 0.3, MIXED, 1.6, 1e-3},   {"lsmps", 4, 0.3, DIRICHLET, 2.7, 3e-5},
    {"lsmps", 4, 0.3, NEUMANN, 2.7, 3e-5}, {"lsmps", 4, 0.3, ROBIN, 2.7, 3e-5},
    {"lsmps", 4, 0.3, MIXED, 2.7, 3e-5},
};

static void observed_order(void **state) {
  (void)state;
  for (size_t k = 0; k < sizeof expectations / sizeof expectations[0]; k++) {
    const expectation *e = &expectations[k];
    const sct_operator op = sct_operator_default(sct_scheme_find(e->scheme), e->degree);
    for (int dim = 1; dim <= 3; dim++) {
      double error[3];
      for (int m = 0; m < 3; m++) {
        error[m] =
            steady_error(dim, MESH[dim][m], &op, e->jitter, 7 + (uint64_t)m, &WALLS[e->walls]);
      }
      const double order =
          log(error[0] / error[2]) / log((double)MESH[dim][2] / (double)MESH[dim][0]);
      print_message("%-6s %d jitter %.1f %-9s %d-D: %.2e %.2e %.2e order %.2f\n", e->scheme,
                    e->degree, e->jitter, WALLS[e->walls].name, dim, error[0], error[1], error[2],
                    order);
      assert_true(order > e->order);
      assert_true(error[2] < e->error);
    }
  }
}

/* u phi_x = mu phi_xx on (0, 1), phi(0) = 0, phi(1) = 1. */
static double nodal_error(sct_upwind upwind, const char *kernel, double radius, double peclet) {
  sct_operator op = sct_operator_default(SCT_PS, 2);
  op.upwind = upwind;
  op.kernel = sct_kernel_find(kernel);
  op.radius = radius;
  const int64_t cells = 16;
  fixture f = fixture_unit(1, cells, 0, 0, &op);
  manufactured m = manufactured_new(&f, 0);
  const double mu = 1 / (peclet * (double)cells);
  for (int64_t i = 0; i <= cells; i++) {
    m.velocity[i] = 1;
    m.diffusivity[i] = mu;
    m.source[i] = m.reaction[i] = 0;
    m.exact[i] =
        peclet < 1e-8 ? f.x[i] : exp((f.x[i] - 1) / mu) * expm1(-f.x[i] / mu) / expm1(-1 / mu);
  }
  m.value[0] = 0;
  m.value[cells] = 1;
  manufactured_steady(&m);
  const double error = sct_norms_of(m.phi, m.exact, f.cloud.n, 1, NULL).linf;
  manufactured_free(&m);
  fixture_clear(&f);
  return error;
}

static void upwinding_is_nodally_exact_in_one_dimension(void **state) {
  (void)state;
  for (double peclet = 1e-6; peclet < 1e9; peclet *= 7) {
    const double errors[] = {nodal_error(SCT_UPWIND_EXACT, "center", 2, peclet),
                             nodal_error(SCT_UPWIND_EXACT, "bell", 1.9, peclet),
                             nodal_error(SCT_UPWIND_EXACT, "rational", 2, peclet),
                             nodal_error(SCT_UPWIND_COSINE, "rational", 2, peclet),
                             nodal_error(SCT_UPWIND_COSINE, "center", 2, peclet)};
    for (size_t k = 0; k < sizeof errors / sizeof errors[0]; k++) {
      if (!(errors[k] < 1e-11)) {
        fail_msg("kernel %d, cell Peclet number %g: error %g", (int)k, peclet, errors[k]);
      }
    }
    if (peclet > 1e-3 && peclet < 1e3) {
      assert_true(nodal_error(SCT_UPWIND_NONE, "center", 2, peclet) > 1e-11);
    }
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(observed_order),
      cmocka_unit_test(upwinding_is_nodally_exact_in_one_dimension),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
