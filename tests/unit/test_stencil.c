/* unit.stencil: names and defaults, operators that are refused, neighbourhoods that are too small
 * or degenerate, the widening of supports, upwind kernels. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fixture.h"

static void names_go_both_ways(void **state) {
  (void)state;
  for (int k = 0; k < SCT_SCHEME_COUNT; k++) {
    assert_int_equal(sct_scheme_find(sct_scheme_name((sct_scheme)k)), k);
  }
  for (int k = 0; k < SCT_UPWIND_COUNT; k++) {
    assert_int_equal(sct_upwind_find(sct_upwind_name((sct_upwind)k)), k);
  }
  assert_int_equal(sct_density_find("reference"), SCT_DENSITY_REFERENCE);
  assert_int_equal(sct_weight_find("kernel"), SCT_WEIGHT_KERNEL);
  assert_int_equal(sct_scheme_find("sph"), SCT_SCHEME_COUNT);
  assert_int_equal(sct_scheme_find(NULL), SCT_SCHEME_COUNT);
  assert_null(sct_scheme_name(SCT_SCHEME_COUNT));
  assert_null(sct_weight_name((sct_weight)-1));
}

static void defaults_are_valid(void **state) {
  (void)state;
  sct_error err;
  for (int k = 0; k < SCT_SCHEME_COUNT; k++) {
    for (int degree = 2; degree <= 4; degree++) {
      const sct_operator op = sct_operator_default((sct_scheme)k, degree);
      expect_ok(sct_operator_check(&op, &err), &err);
    }
  }
  assert_string_equal(sct_operator_default(SCT_MPS, 2).kernel->name, "center");
  assert_int_equal(sct_operator_default(SCT_MPS, 2).density, SCT_DENSITY_REFERENCE);
  assert_int_equal(sct_operator_default(SCT_LSMPS, 99).degree, 2);
}

static void bad_operators_are_refused(void **state) {
  (void)state;
  const sct_operator good = sct_operator_default(SCT_IPS, 2);
  sct_operator bad[9];
  for (int k = 0; k < 9; k++) bad[k] = good;
  bad[0].radius = 0.99;
  bad[1].radius = NAN;
  bad[2].degree = 1;
  bad[3].kernel = NULL;
  bad[4].upwind = SCT_UPWIND_PUBLISHED;
  bad[5].reference_length = 0;
  bad[6].gamma_scale = INFINITY;
  bad[7].scheme = SCT_SCHEME_COUNT;
  bad[8].upwind = SCT_UPWIND_EXACT; /* no kernel falls at its own edge */
  bad[8].radius = 1;
  for (int k = 0; k < 9; k++) {
    sct_error err;
    assert_int_equal(sct_operator_check(&bad[k], &err), SCT_E_ARGUMENT);
    assert_true(strlen(err.text) > 10);
  }
}

static sct_status row_of(const fixture *f, int64_t i, int want, sct_row *row, sct_error *err) {
  sct_room *room = NULL;
  expect_ok(sct_room_new(f->stencil, &room, err), err);
  const sct_status status =
      sct_stencil_row(f->stencil, i, &(const sct_row_request){.want = want}, room, row, err);
  sct_room_free(&room);
  return status;
}

static void a_line_in_the_plane_is_deficient(void **state) {
  (void)state;
  double x[20];
  sct_row row;
  sct_error err;
  for (int k = 0; k < 10; k++) {
    x[2 * k] = 0.3 * k;
    x[2 * k + 1] = 0.4 * k;
  }
  for (int scheme = 0; scheme < SCT_SCHEME_COUNT; scheme++) {
    const sct_operator op = sct_operator_default((sct_scheme)scheme, 2);
    fixture f = fixture_points(2, 10, x, 0.5, &op);
    assert_int_equal(row_of(&f, 4, SCT_ROW_LAPLACIAN, &row, &err), SCT_E_DEFICIENT);
    assert_int_equal(err.point, 4);
    assert_int_equal(row_of(&f, 4, SCT_ROW_GRADIENT, &row, &err), SCT_E_DEFICIENT);
    fixture_clear(&f);
  }
}

static void an_isolated_point_is_named(void **state) {
  (void)state;
  const sct_operator op = sct_operator_default(SCT_LSMPS, 2);
  double x[2 * 37];
  char message[600];
  sct_error err;
  for (int k = 0; k < 36; k++) {
    x[2 * k] = k % 6;
    x[2 * k + 1] = k / 6;
  }
  x[72] = 100;
  x[73] = 100;
  fixture f = fixture_points(2, 37, x, 1, &op);
  double field[37] = {0}, lap[37];
  assert_int_equal(sct_stencil_apply(f.stencil, field, NULL, NULL, NULL, lap, &err),
                   SCT_E_DEFICIENT);
  assert_int_equal(err.count, 1);
  assert_string_equal(
      sct_error_message(&err, message, sizeof message),
      "point 36 has 0 neighbours within 32.00 spacings, which are too few for lsmps "
      "in 2-D, needs 6");
  fixture_clear(&f);
}

/* Thin a lattice until some points have too few neighbours: their support is widened and the row
 * stays exact. */
static void a_thin_neighbourhood_is_widened(void **state) {
  (void)state;
  const sct_operator op = sct_operator_default(SCT_LSMPS, 2);
  double x[2 * 400];
  int64_t n = 0, middle = -1;
  uint64_t random = 4;
  for (int k = 0; k < 400; k++) {
    const double a = k % 20, b = k / 20;
    const double r = hypot(a - 10, b - 10);
    if (r > 0 && r < 2.6) continue; /* a hole around the point (10, 10) */
    if (r == 0) middle = n;
    x[2 * n] = a + 0.1 * fixture_random(&random);
    x[2 * n++ + 1] = b + 0.1 * fixture_random(&random);
  }
  fixture f = fixture_points(2, n, x, 1, &op);
  sct_room *room = NULL;
  sct_row row;
  sct_error err;
  expect_ok(sct_room_new(f.stencil, &room, &err), &err);
  expect_ok(sct_stencil_row(f.stencil, middle,
                            &(const sct_row_request){.want = SCT_ROW_LAPLACIAN | SCT_ROW_SOLVE},
                            room, &row, &err),
            &err);
  assert_int_equal(row.flags, SCT_ROW_WIDENED);
  assert_true(row.support > 2.6 && row.n >= 6);
  double sum = 0;
  for (int64_t k = 0; k < row.n; k++) {
    const double dx = x[2 * row.index[k]] - x[2 * middle];
    const double dy = x[2 * row.index[k] + 1] - x[2 * middle + 1];
    sum += row.laplacian[k] * (3 * dx * dx - dy * dy + dx * dy + dx);
    assert_int_not_equal(row.index[k], middle);
  }
  assert_true(fabs(sum - 4) < 1e-9);
  sct_room_free(&room);
  fixture_clear(&f);
}

/* What is asked of a row to solve with: every accepted row keeps sum |l| <= 1.5 sum l, and rows of
 * any cloud are the same whatever the number of threads. */
/* An application tells what became of each row, as the rows do one by one. */
static void an_application_tells_of_its_rows(void **state) {
  (void)state;
  const sct_operator op = sct_operator_default(SCT_LSMPS, 2);
  fixture f = fixture_unit(2, 8, 0.4, 3, &op);
  double *phi = fixture_alloc(f.cloud.n, sizeof *phi), *out = fixture_alloc(f.cloud.n, sizeof *out);
  uint8_t *flags = fixture_alloc(f.cloud.n, sizeof *flags);
  int64_t widened = 0;
  sct_room *room = NULL;
  sct_row row;
  sct_error err;
  for (int64_t i = 0; i < f.cloud.n; i++) phi[i] = sin((double)i);
  expect_ok(sct_stencil_apply_flagged(f.stencil, phi, NULL, NULL, NULL, out, flags, &err), &err);
  expect_ok(sct_room_new(f.stencil, &room, &err), &err);
  for (int64_t i = 0; i < f.cloud.n; i++) {
    expect_ok(sct_stencil_row(f.stencil, i, &(const sct_row_request){.want = SCT_ROW_LAPLACIAN},
                              room, &row, &err),
              &err);
    assert_int_equal(flags[i], row.flags);
    widened += (flags[i] & SCT_ROW_WIDENED) != 0;
  }
  assert_true(widened > 0 && widened < f.cloud.n); /* corners */
  expect_ok(sct_stencil_apply_flagged(f.stencil, phi, NULL, out, NULL, NULL, flags, &err), &err);
  for (int64_t i = 0; i < f.cloud.n; i++) assert_int_equal(flags[i], 0);
  sct_room_free(&room);
  free(phi);
  free(out);
  free(flags);
  fixture_clear(&f);
}

static void rows_to_solve_with_are_stable(void **state) {
  (void)state;
  const sct_operator op = sct_operator_default(SCT_LSMPS, 2);
  fixture f = fixture_unit(2, 30, 0.5, 8, &op);
  sct_room *room = NULL;
  sct_row row;
  sct_error err;
  expect_ok(sct_room_new(f.stencil, &room, &err), &err);
  for (int64_t i = 0; i < f.cloud.n; i++) {
    if (!f.inside[i]) continue;
    expect_ok(sct_stencil_row(f.stencil, i,
                              &(const sct_row_request){.want = SCT_ROW_LAPLACIAN | SCT_ROW_SOLVE},
                              room, &row, &err),
              &err);
    double sum = 0, size = 0;
    for (int64_t k = 0; k < row.n; k++) {
      sum += row.laplacian[k];
      size += fabs(row.laplacian[k]);
    }
    if (!(row.flags & (SCT_ROW_FALLBACK | SCT_ROW_LOOSE))) assert_true(size <= 1.5 * sum);
    assert_true(sum > 0);
  }
  sct_room_free(&room);
  fixture_clear(&f);
}

static void threads_do_not_matter(void **state) {
  (void)state;
  const sct_operator op = sct_operator_default(SCT_LSMPS, 2);
  fixture f = fixture_unit(2, 40, 0.4, 2, &op);
  double *a = fixture_alloc(f.cloud.n, sizeof *a), *b = fixture_alloc(f.cloud.n, sizeof *b);
  const sct_work two = {.threads = 2};
  sct_error err;
  for (int64_t i = 0; i < f.cloud.n; i++) a[i] = sin((double)i);
  double *field = fixture_alloc(f.cloud.n, sizeof *field);
  memcpy(field, a, (size_t)f.cloud.n * sizeof *a);
  expect_ok(sct_stencil_apply(f.stencil, field, NULL, NULL, NULL, a, &err), &err);
  expect_ok(sct_stencil_apply(f.stencil, field, &two, NULL, NULL, b, &err), &err);
  assert_memory_equal(a, b, (size_t)f.cloud.n * sizeof *a);
  free(a);
  free(b);
  free(field);
  fixture_clear(&f);
}

static void beta_is_continuous_and_bounded(void **state) {
  (void)state;
  assert_true(sct_upwind_beta(0) == 0);
  assert_true(sct_upwind_beta(INFINITY) == 1);
  assert_true(sct_upwind_beta(-INFINITY) == -1);
  assert_true(fabs(sct_upwind_beta(1) - (1 / tanh(1) - 1)) < 1e-15);
  for (double g = 1e-9; g < 1e9; g *= 1.01) {
    const double beta = sct_upwind_beta(g), next = sct_upwind_beta(g * 1.01);
    assert_true(beta > 0 && beta <= 1 && next >= beta);
    assert_true(sct_upwind_beta(-g) == -beta);
    assert_true(next - beta <= 0.0101 * g / 3 + 1e-15); /* its slope is at most 1/3 */
  }
  /* both sides of the switch to the series */
  assert_true(fabs(sct_upwind_beta(0.02 * (1 - 1e-15)) - sct_upwind_beta(0.02)) < 1e-13);
}

/* The kernel of the gradient leans upstream: for u along x the upstream neighbour counts 1 + beta,
 * the downstream one 1 - beta. */
static void the_upwind_gradient_leans_upstream(void **state) {
  (void)state;
  sct_operator op = sct_operator_default(SCT_PS, 2);
  op.upwind = SCT_UPWIND_COSINE;
  fixture f = fixture_unit(1, 10, 0, 0, &op);
  const double u = 2, mu = 0.05, h = 0.1, beta = sct_upwind_beta(u * h / (2 * mu));
  sct_room *room = NULL;
  sct_row row;
  sct_error err;
  expect_ok(sct_room_new(f.stencil, &room, &err), &err);
  expect_ok(sct_stencil_row(f.stencil, 5, &(sct_row_request){SCT_ROW_GRADIENT, &u, mu, NULL}, room,
                            &row, &err),
            &err);
  assert_int_equal(row.n, 2);
  for (int64_t k = 0; k < 2; k++) {
    const double c = row.index[k] > 5 ? 1 : -1;
    assert_true(fabs(row.gradient[k] - c * (1 - beta * c) / (2 * h)) < 1e-9);
  }
  sct_room_free(&room);
  fixture_clear(&f);
}

/* Velocities whose squares are no doubles are upwinded like any other. */
static void the_upwind_gradient_depends_on_the_peclet_number_only(void **state) {
  (void)state;
  sct_operator op = sct_operator_default(SCT_IPS, 2);
  op.upwind = SCT_UPWIND_COSINE;
  fixture f = fixture_unit(2, 6, 0.2, 3, &op);
  double gradient[2][64];
  sct_room *room = NULL;
  sct_row row;
  sct_error err;
  expect_ok(sct_room_new(f.stencil, &room, &err), &err);
  static const int powers[] = {0, -1000, 1000};
  for (int k = 0; k < 3; k++) {
    const double u[2] = {ldexp(3, powers[k]), ldexp(-1, powers[k])}, mu = ldexp(0.25, powers[k]);
    const sct_row_request request = {SCT_ROW_GRADIENT, u, mu, NULL};
    expect_ok(sct_stencil_row(f.stencil, 24, &request, room, &row, &err), &err);
    assert_in_range(row.n, 4, 32);
    for (int64_t e = 0; e < 2 * row.n; e++) gradient[k > 0][e] = row.gradient[e];
    for (int64_t e = 0; e < 2 * row.n && k > 0; e++) {
      assert_true(fabs(gradient[1][e] - gradient[0][e]) < 1e-12);
    }
  }
  sct_room_free(&room);
  fixture_clear(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(names_go_both_ways),
      cmocka_unit_test(defaults_are_valid),
      cmocka_unit_test(bad_operators_are_refused),
      cmocka_unit_test(a_line_in_the_plane_is_deficient),
      cmocka_unit_test(an_isolated_point_is_named),
      cmocka_unit_test(a_thin_neighbourhood_is_widened),
      cmocka_unit_test(an_application_tells_of_its_rows),
      cmocka_unit_test(rows_to_solve_with_are_stable),
      cmocka_unit_test(threads_do_not_matter),
      cmocka_unit_test(beta_is_continuous_and_bounded),
      cmocka_unit_test(the_upwind_gradient_leans_upstream),
      cmocka_unit_test(the_upwind_gradient_depends_on_the_peclet_number_only),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
