/* verify.diagnose: what is reported of a cloud is what the operators do to polynomials. */
#include <math.h>
#include <stdlib.h>

#include "fixture.h"

static double largest_difference(const double *a, const double *b, int64_t n) {
  double worst = 0;
  for (int64_t i = 0; i < n; i++) worst = fmax(worst, fabs(a[i] - b[i]));
  return worst;
}

static void ps_laplacian_of_a_coordinate_is_the_artificial_velocity(void **state) {
  (void)state;
  const int64_t cells[] = {0, 50, 16, 8};
  for (int dim = 1; dim <= 3; dim++) {
    sct_operator op = sct_operator_default(SCT_PS, 2);
    op.radius = 2;
    fixture f = fixture_unit(dim, cells[dim], 0.4, 11, &op);
    const int64_t n = f.cloud.n;
    double *u = fixture_alloc(n * dim, sizeof *u), *lap = fixture_alloc(n, sizeof *lap);
    double *ua = fixture_alloc(n, sizeof *ua), *field = fixture_alloc(n, sizeof *field);
    sct_error err;
    const sct_diagnosis to = {.artificial_velocity = u};
    expect_ok(sct_diagnose(f.stencil, NULL, &to, &err), &err);
    for (int a = 0; a < dim; a++) {
      for (int64_t i = 0; i < n; i++) field[i] = f.x[i * dim + a];
      for (int64_t i = 0; i < n; i++) ua[i] = u[i * dim + a];
      expect_ok(sct_stencil_apply(f.stencil, field, NULL, NULL, NULL, lap, &err), &err);
      assert_true(largest_difference(ua, lap, n) < 1e-9);
      assert_true(sct_range_of(ua, n, 1, f.inside).rms > 1);
    }
    free(u);
    free(lap);
    free(ua);
    free(field);
    fixture_clear(&f);
  }
}

/* lap of r_a r_b / 2 at the point itself = tau_ab, for ips on any cloud. */
static void ips_laplacian_of_a_quadratic_is_the_effective_diffusivity(void **state) {
  (void)state;
  const sct_operator op = sct_operator_default(SCT_IPS, 2);
  static const int ab[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
  fixture f = fixture_unit(3, 7, 0.4, 3, &op);
  const int64_t n = f.cloud.n;
  double *t = fixture_alloc(n * 6, sizeof *t), *lap = fixture_alloc(n, sizeof *lap);
  double *field = fixture_alloc(n, sizeof *field), *te = fixture_alloc(n, sizeof *te);
  sct_error err;
  const sct_diagnosis to = {.effective_diffusivity = t};
  expect_ok(sct_diagnose(f.stencil, NULL, &to, &err), &err);
  for (int e = 0; e < 6; e++) {
    for (int64_t i = 0; i < n; i++) {
      field[i] = 0.5 * f.x[3 * i + ab[e][0]] * f.x[3 * i + ab[e][1]];
      te[i] = t[6 * i + e];
    }
    expect_ok(sct_stencil_apply(f.stencil, field, NULL, NULL, NULL, lap, &err), &err);
    for (int64_t i = 0; i < n; i++) {
      if (!f.inside[i]) lap[i] = te[i] = 0; /* boundary rows may be widened, the diagnosis is not */
    }
    assert_true(largest_difference(te, lap, n) < 1e-9);
    assert_true(sct_range_of(te, n, 1, f.inside).rms > (e < 3 ? 0.5 : 1e-3));
  }
  free(t);
  free(lap);
  free(field);
  free(te);
  fixture_clear(&f);
}

/* On a lattice nothing is artificial, and every interior point sees the same. */
static void a_lattice_is_perfect(void **state) {
  (void)state;
  sct_operator op = sct_operator_default(SCT_PS, 2);
  op.radius = 2;
  fixture f = fixture_unit(2, 20, 0, 0, &op);
  const int64_t n = f.cloud.n;
  int32_t *count = fixture_alloc(n, sizeof *count);
  double *density = fixture_alloc(n, sizeof *density), *u = fixture_alloc(2 * n, sizeof *u);
  double *t = fixture_alloc(3 * n, sizeof *t), *condition = fixture_alloc(n, sizeof *condition);
  sct_error err;
  const sct_diagnosis to = {count, density, u, t, condition};
  expect_ok(sct_diagnose(f.stencil, NULL, &to, &err), &err);
  for (int64_t i = 0; i < n; i++) {
    if (!f.inside[i]) continue;
    assert_int_equal(count[i], 8);
    assert_true(fabs(density[i] - (4 + 4 * (sqrt(2) - 1))) < 1e-10); /* 5.657, flow.md's n0 */
    assert_true(fabs(u[2 * i]) < 1e-9 && fabs(u[2 * i + 1]) < 1e-9);
    assert_true(fabs(t[3 * i] - 1) < 1e-10 && fabs(t[3 * i + 1] - 1) < 1e-10);
    assert_true(fabs(t[3 * i + 2]) < 1e-10);
    assert_true(fabs(condition[i] - 1) < 1e-10);
  }
  free(count);
  free(density);
  free(u);
  free(t);
  free(condition);
  fixture_clear(&f);
}

/* Errors may be so small or large that their squares are no doubles. */
static void norms_are_of_the_size_of_the_errors(void **state) {
  (void)state;
  static const int powers[] = {-1060, -700, 0, 700, 1020};
  static const uint8_t mask[] = {1, 1, 0, 1};
  for (size_t k = 0; k < sizeof powers / sizeof *powers; k++) {
    const double unit = ldexp(1, powers[k]);
    const double value[] = {3 * unit, 4 * unit, 9 * unit, unit}, exact[] = {0, 0, unit, unit};
    const sct_norms norms = sct_norms_of(value, exact, 4, 1, mask);
    assert_true(fabs(norms.l2 / unit - sqrt(25.0 / 3)) < 1e-3); /* a denormal unit is coarse */
    assert_true(fabs(norms.l2_relative - 5) < 1e-3);
    assert_true(norms.l1 == 7 * unit / 3 && norms.linf == 4 * unit && norms.linf_all == 8 * unit);
    const sct_norms vectors = sct_norms_of(value, exact, 2, 2, NULL);
    assert_true(fabs(vectors.linf / unit - 8) < 1e-3 && fabs(vectors.l1 / unit - 6.5) < 1e-3);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(ps_laplacian_of_a_coordinate_is_the_artificial_velocity),
      cmocka_unit_test(ips_laplacian_of_a_quadratic_is_the_effective_diffusivity),
      cmocka_unit_test(a_lattice_is_perfect),
      cmocka_unit_test(norms_are_of_the_size_of_the_errors),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
