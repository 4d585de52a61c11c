/* unit.limited: the correction against (1) to (4) of limited.h written out, on a line whose weights
 * are known and on clouds; what the first-order part and the reach hold; failures. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "limited_problem.h"
#include "near.h"

enum { POINTS = 9 };
static const double h = 1.0 / (POINTS - 1);

static double speed = 1;

static void along(const double *x, double *u) {
  (void)x;
  u[0] = speed;
}

static double zero(const double *x) {
  (void)x;
  return 0;
}

/* A line of points with two neighbours each: k_ij = +-u / 2h, G = (phi_+ - phi_-) / 2h. */
static limited_problem line_of(sct_scheme scheme, double mu) {
  const posed p = {along, zero, NULL, NULL, mu};
  const sct_lattice lattice = {.dim = 1, .upper = {1}, .cells = {POINTS - 1}};
  sct_operator op = limited_operator(scheme);
  op.radius = 1.5;
  return limited_problem_new(&p, &lattice, &op);
}

static double limiter(double a, double b) {
  return a * b > 0 ? a * b * (a + b) / (a * a + b * b) : 0;
}

/* q of a flow to the right at i: 2G.r - D is the difference on the other side. */
static double correction_at(const double *phi, int i) {
  const double k = 1 / (2 * h), right = phi[i + 1] - phi[i], left = phi[i] - phi[i - 1];
  const double before = i > 1 ? phi[i - 1] - phi[i - 2] : left; /* one-sided at the end */
  return -k * limiter(left, right) + k * limiter(before, left);
}

static void correction_on_a_line(void **state) {
  static const double fields[][POINTS] = {
      {0, 1, 2, 3, 4, 5, 6, 7, 8},
      {0, 1, 4, 9, 16, 25, 36, 49, 64},
      {0, 0, 0, 0, 1, 1, 1, 1, 1},
      {3, -1, 4, 1, -5, 9, 2, -6, 5},
  };
  double gradient[POINTS], q[POINTS];
  (void)state;
  speed = 1;
  limited_problem p = line_of(SCT_PS, 0.01);
  for (size_t f = 0; f < sizeof fields / sizeof *fields; f++) {
    sct_limited_correction(p.system, fields[f], NULL, gradient, q);
    for (int row = 0; row < POINTS - 2; row++) {
      assert_near(q[row], correction_at(fields[f], row + 1), 1e-10);
    }
  }
  limited_problem_clear(&p);
}

/* A phi - q(phi) of a linear field is u . grad phi, on any cloud and for any scheme. */
static int dim;

static void oblique(const double *x, double *u) {
  static const double speeds[] = {0.6, -0.3, 0.2};
  (void)x;
  memcpy(u, speeds, (size_t)dim * sizeof *u);
}

static double plane(const double *x) {
  return 1 + 2 * x[0] - x[1] + (dim == 3 ? 0.5 * x[2] : 0);
}

static void linear_on(sct_scheme scheme) {
  const posed p = {oblique, plane, NULL, NULL, 1e-3};
  const sct_lattice lattice = {
      .dim = dim, .upper = {1, 1, 1}, .cells = {6, 6, 6}, .jitter = 0.5, .seed = 5};
  const sct_operator op = limited_operator(scheme);
  limited_problem problem = limited_problem_new(&p, &lattice, &op);
  const int64_t n = problem.f.cloud.n, m = problem.system->unknowns;
  double *phi = fixture_alloc(n, sizeof *phi), *gradient = fixture_alloc(n * dim, sizeof *gradient);
  double *q = fixture_alloc(m, sizeof *q), *b = fixture_alloc(m, sizeof *b);
  double *y = fixture_alloc(m, sizeof *y);
  for (int64_t i = 0; i < n; i++) phi[i] = plane(problem.f.cloud.x + i * dim);
  sct_limited_correction(problem.system, phi, NULL, gradient, q);
  sct_system_rhs(problem.system, phi, b); /* - coupling phi */
  for (int64_t row = 0; row < m; row++) y[row] = phi[problem.system->point_of[row]];
  sct_csr_multiply_add(problem.system->matrix, -1, y, b);
  const double expected = 0.6 * 2 + 0.3 + (dim == 3 ? 0.1 : 0);
  for (int64_t row = 0; row < m; row++) assert_near(-b[row] - q[row], expected, 1e-10);
  free(phi);
  free(gradient);
  free(q);
  free(b);
  free(y);
  limited_problem_clear(&problem);
}

static void linear_fields_are_exact(void **state) {
  (void)state;
  for (dim = 2; dim <= 3; dim++) {
    linear_on(SCT_IPS);
    linear_on(SCT_IPSN);
    linear_on(SCT_LSMPS);
  }
}

/* Off the diagonal nothing positive, whatever the cloud: ps has no negative weights to begin with.
 */
static void first_order_part_is_an_m_matrix(void **state) {
  const posed p = {oblique, zero, NULL, NULL, 1e-3};
  const sct_lattice lattice = {
      .dim = 2, .upper = {1, 1}, .cells = {12, 12}, .jitter = 0.5, .seed = 2};
  const sct_operator op = limited_operator(SCT_PS);
  (void)state;
  dim = 2;
  limited_problem problem = limited_problem_new(&p, &lattice, &op);
  const sct_csr *a = problem.system->matrix;
  for (int64_t row = 0; row < problem.system->unknowns; row++) {
    for (int64_t e = a->start[row]; e < a->start[row + 1]; e++) {
      assert_true(a->column[e] == row ? a->value[e] > 0 : a->value[e] <= 0);
    }
  }
  limited_problem_clear(&problem);
}

/* On the line: 2 (2 STEEPEST) k with STEEPEST = (1 + sqrt 2) / 2. */
static void reach_of_a_line(void **state) {
  (void)state;
  speed = -3;
  limited_problem p = line_of(SCT_PS, 0.01);
  for (int64_t row = 0; row < p.system->unknowns; row++) {
    assert_near(sct_limited_reach(p.system, row), 2 * (1 + sqrt(2)) * 3 / (2 * h), 1e-2);
  }
  limited_problem_clear(&p);
}

/* Rest: nothing to limit, the answer is that of one back-substitution. */
static void rest_takes_two_steps(void **state) {
  sct_error err;
  const sct_limited_options options = {0};
  (void)state;
  speed = 0;
  limited_problem p = line_of(SCT_PS, 1);
  p.phi[POINTS - 1] = 1;
  expect_ok(limited_problem_solve(&p, &options, &err), &err);
  assert_int_equal(p.report.iterations, 2);
  for (int i = 0; i < POINTS; i++) assert_near(p.phi[i], i * h, 1e-12);
  limited_problem_clear(&p);
}

static void report_tells_every_iteration(void **state) {
  sct_error err;
  const sct_limited_options options = {.tolerance = 1e-10};
  (void)state;
  speed = 1;
  limited_problem p = line_of(SCT_LSMPS, 0.05);
  p.phi[0] = 1;
  expect_ok(limited_problem_solve(&p, &options, &err), &err);
  const int64_t last = p.report.iterations - 1;
  assert_true(last > 1 && p.report.total == p.report.iterations && p.report.most == last + 1);
  assert_true(p.report.history[last] == p.report.residual && p.report.residual <= 1e-10);
  for (int64_t k = 0; k < last; k++) assert_true(p.report.history[k] > 1e-10 || k == 0);
  limited_problem_clear(&p);
}

static void degrees_above_two_are_refused(void **state) {
  sct_operator op = sct_operator_default(SCT_LSMPS, 3);
  sct_lattice lattice = {.dim = 1, .upper = {1}, .cells = {20}};
  sct_error err;
  (void)state;
  fixture f = fixture_lattice(&lattice, &op);
  op.upwind = SCT_UPWIND_LIMITED;
  sct_stencil *stencil;
  const sct_status status = sct_stencil_build(&f.cloud, f.search, f.spacing, &op,
                                              FIXTURE_NEIGHBOURS, NULL, &stencil, &err);
  assert_int_equal(status, SCT_E_ARGUMENT);
  assert_null(stencil);
  fixture_clear(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(correction_on_a_line),
      cmocka_unit_test(linear_fields_are_exact),
      cmocka_unit_test(first_order_part_is_an_m_matrix),
      cmocka_unit_test(reach_of_a_line),
      cmocka_unit_test(rest_takes_two_steps),
      cmocka_unit_test(report_tells_every_iteration),
      cmocka_unit_test(degrees_above_two_are_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
