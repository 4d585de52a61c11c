/* verify.assemble: manufactured solutions with every term and boundary type, observed order in 1, 2
 * and 3 dimensions; exact nodal values of one-dimensional upwinding. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "fixture.h"

/* phi = sin(1.3 x + 0.4) cos(0.9 y - 0.2) e^(z/2), mu = 1 + 0.3 x + 0.2 y + 0.1 z,
 * u = (y - 1/2, 1/2 - x, 0.3), k = 0.5 + x */
typedef struct {
  double phi, gradient[3], laplacian, mu, u[3], k, source;
} truth;

static truth truth_at(int dim, const double *at) {
  const double x = at[0], y = dim > 1 ? at[1] : 0.2 / 0.9, z = dim > 2 ? at[2] : 0;
  const double sx = sin(1.3 * x + 0.4), cx = cos(1.3 * x + 0.4);
  const double sy = sin(0.9 * y - 0.2), cy = cos(0.9 * y - 0.2), e = exp(0.5 * z);
  const double grad_mu[3] = {0.3, 0.2, 0.1};
  truth t = {.phi = sx * cy * e,
             .gradient = {1.3 * cx * cy * e, -0.9 * sx * sy * e, 0.5 * sx * cy * e},
             .mu = 1 + 0.3 * x + (dim > 1 ? 0.2 * y : 0) + (dim > 2 ? 0.1 * z : 0),
             .u = {(dim > 1 ? y : 1) - 0.5, 0.5 - x, 0.3},
             .k = 0.5 + x};
  const double second[3] = {-1.69 * t.phi, -0.81 * t.phi, 0.25 * t.phi};
  t.source = t.k * t.phi;
  for (int a = 0; a < dim; a++) {
    t.laplacian += second[a];
    t.source += t.u[a] * t.gradient[a] - grad_mu[a] * t.gradient[a];
  }
  t.source -= t.mu * t.laplacian;
  return t;
}

/* Fields, boundary data and answer of a problem, point by point. */
typedef struct {
  double *velocity, *diffusivity, *source, *reaction, *value, *coefficient, *normal, *exact, *phi;
  uint8_t *condition;
} data;

static data data_new(int64_t n, int dim) {
  data d;
  double **const arrays[] = {&d.velocity,    &d.diffusivity, &d.source, &d.reaction, &d.value,
                             &d.coefficient, &d.normal,      &d.exact,  &d.phi};
  for (size_t k = 0; k < sizeof arrays / sizeof arrays[0]; k++) {
    *arrays[k] = fixture_alloc(n * dim, sizeof(double));
  }
  d.condition = fixture_alloc(n, 1);
  return d;
}

static void data_free(data *d) {
  double *const arrays[] = {d->velocity,    d->diffusivity, d->source, d->reaction, d->value,
                            d->coefficient, d->normal,      d->exact,  d->phi};
  for (size_t k = 0; k < sizeof arrays / sizeof arrays[0]; k++) free(arrays[k]);
  free(d->condition);
}

static void paint(const fixture *f, data *d, sct_side side, sct_condition condition) {
  sct_group group;
  sct_error err;
  const int dim = f->cloud.dim;
  expect_ok(sct_lattice_group(&f->lattice, side, &group, &err), &err);
  for (int64_t k = 0; k < group.n; k++) {
    const int64_t i = group.index[k];
    const truth t = truth_at(dim, f->x + i * dim);
    double slope = 0;
    for (int a = 0; a < dim; a++) {
      const double normal = group.normal[(group.normals == 1 ? 0 : k) * dim + a];
      d->normal[i * dim + a] = normal;
      slope += normal * t.gradient[a];
    }
    d->condition[i] = (uint8_t)condition;
    d->coefficient[i] = 2;
    d->value[i] = condition == SCT_DIRICHLET ? t.phi
                  : condition == SCT_NEUMANN ? slope
                                             : 2 * t.phi + slope;
  }
  sct_group_clear(&group);
}

/* Solves the assembled system into d->phi. */
static void solve(const fixture *f, data *d) {
  const sct_fields fields = {d->velocity, d->diffusivity, d->source, d->reaction};
  const sct_boundary boundary = {d->condition, d->value, d->coefficient, d->normal};
  const sct_solve_options options = {.dim = f->cloud.dim, .method = "auto"};
  const sct_work work = {.threads = 2};
  sct_system *system = NULL;
  sct_solver *solver = NULL;
  sct_error err;
  expect_ok(sct_system_build(f->stencil, &fields, &boundary, &work, &system, &err), &err);
  double *b = fixture_alloc(system->unknowns, sizeof *b), *x = fixture_alloc(system->unknowns, 8);
  for (int64_t i = 0; i < f->cloud.n; i++) {
    if (d->condition[i] == SCT_DIRICHLET) d->phi[i] = d->value[i];
  }
  sct_system_rhs(system, d->phi, b);
  expect_ok(sct_solver_analyse(system->matrix, &options, &solver, &err), &err);
  expect_ok(sct_solver_factor(solver, system->matrix, &err), &err);
  expect_ok(sct_solver_solve(solver, b, false, x, &err), &err);
  for (int64_t row = 0; row < system->unknowns; row++) d->phi[system->point_of[row]] = x[row];
  sct_solver_free(&solver);
  sct_system_free(&system);
  free(b);
  free(x);
}

/* Root mean square error of the manufactured problem; mixed boundary or all Dirichlet. */
static double manufactured_error(int dim, int64_t cells, const sct_operator *op, double jitter,
                                 uint64_t seed, bool mixed) {
  fixture f = fixture_unit(dim, cells, jitter, seed, op);
  data d = data_new(f.cloud.n, dim);
  for (int64_t i = 0; i < f.cloud.n; i++) {
    const truth t = truth_at(dim, f.x + i * dim);
    for (int a = 0; a < dim; a++) d.velocity[i * dim + a] = t.u[a];
    d.diffusivity[i] = t.mu;
    d.reaction[i] = t.k;
    d.source[i] = t.source;
    d.exact[i] = t.phi;
  }
  paint(&f, &d, SCT_SIDE_BOUNDARY, SCT_DIRICHLET);
  if (mixed) paint(&f, &d, SCT_SIDE_RIGHT, SCT_ROBIN);
  if (mixed && dim > 1) paint(&f, &d, SCT_SIDE_TOP, SCT_NEUMANN);
  solve(&f, &d);
  const double error = sct_norms_of(d.phi, d.exact, f.cloud.n, 1, f.inside).l2;
  data_free(&d);
  fixture_clear(&f);
  return error;
}

typedef struct {
  const char *scheme;
  int degree;
  double jitter;
  bool mixed;
  double order, error; /* least observed order, largest error on the finest mesh */
} expectation;

static const int64_t MESH[][3] = {{0}, {20, 40, 80}, {10, 20, 40}, {6, 10, 14}};

static const expectation expectations[] = {
    {"mps", 2, 0.0, false, 1.8, 1e-3},  {"ps", 2, 0.0, false, 1.8, 1e-3},
    {"ips", 2, 0.0, false, 1.8, 1e-3},  {"ips", 2, 0.3, false, -9, 2e-2},
    {"ipsn", 2, 0.3, false, -9, 2e-2},  {"ips", 2, 0.0, true, 0.8, 2e-2},
    {"lsmps", 2, 0.0, true, 1.8, 1e-3}, {"lsmps", 2, 0.3, true, 1.5, 1e-3},
    {"lsmps", 3, 0.3, true, 1.6, 3e-4}, {"lsmps", 4, 0.3, true, 2.7, 3e-5},
};

static void observed_order(void **state) {
  (void)state;
  for (size_t k = 0; k < sizeof expectations / sizeof expectations[0]; k++) {
    const expectation *e = &expectations[k];
    const sct_operator op = sct_operator_default(sct_scheme_find(e->scheme), e->degree);
    for (int dim = 1; dim <= 3; dim++) {
      double error[3];
      for (int m = 0; m < 3; m++) {
        error[m] = manufactured_error(dim, MESH[dim][m], &op, e->jitter, 7 + m, e->mixed);
      }
      const double order =
          log(error[0] / error[2]) / log((double)MESH[dim][2] / (double)MESH[dim][0]);
      print_message("%-6s %d jitter %.1f %s %d-D: %.2e %.2e %.2e order %.2f\n", e->scheme,
                    e->degree, e->jitter, e->mixed ? "mixed    " : "dirichlet", dim, error[0],
                    error[1], error[2], order);
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
  data d = data_new(f.cloud.n, 1);
  const double mu = 1 / (peclet * (double)cells);
  for (int64_t i = 0; i <= cells; i++) {
    d.velocity[i] = 1;
    d.diffusivity[i] = mu;
    d.exact[i] =
        peclet < 1e-8 ? f.x[i] : exp((f.x[i] - 1) / mu) * expm1(-f.x[i] / mu) / expm1(-1 / mu);
  }
  d.condition[0] = d.condition[cells] = SCT_DIRICHLET;
  d.value[cells] = 1;
  solve(&f, &d);
  const double error = sct_norms_of(d.phi, d.exact, f.cloud.n, 1, NULL).linf;
  data_free(&d);
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
