#include <inttypes.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "scatter/cloud.h"

static sct_lattice lattice_of(int dim, double jitter, uint64_t seed) {
  sct_lattice l = {dim, {-1, 0.1, 2}, {1, 0.7, 2.5}, {6, 4, 3}, jitter, seed};
  return l;
}

static double *points_of(const sct_lattice *l) {
  double *x = malloc((size_t)(sct_lattice_count(l) * l->dim) * sizeof *x);
  sct_lattice_points(l, x);
  return x;
}

/* Place of point p, and whether it is strictly inside. */
static bool place_of(const sct_lattice *l, int64_t p, int64_t *i) {
  bool inside = true;
  for (int k = 0; k < l->dim; k++) {
    i[k] = p % (l->cells[k] + 1);
    p /= l->cells[k] + 1;
    inside = inside && i[k] > 0 && i[k] < l->cells[k];
  }
  return inside;
}

/* The formula of the header, written down anew. */
static double chi(uint64_t seed, uint64_t m) {
  const uint64_t g = 0x9e3779b97f4a7c15u;
  uint64_t z = seed + (m + 1) * g;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return (double)((z ^ (z >> 31)) >> 11) * pow(2, -53);
}

/* -- points ------------------------------------------------------------------------------------ */

static void numbers_x_fastest(void **state) {
  (void)state;
  for (int dim = 1; dim <= 3; dim++) {
    sct_lattice l = lattice_of(dim, 0, 9);
    double *x = points_of(&l);
    assert_int_equal(sct_lattice_count(&l), dim == 1 ? 7 : dim == 2 ? 35 : 140);
    for (int64_t p = 0; p < sct_lattice_count(&l); p++) {
      int64_t i[SCT_DIM_MAX];
      place_of(&l, p, i);
      for (int k = 0; k < dim; k++) {
        double c = (double)l.cells[k], extent = l.upper[k] - l.lower[k];
        double expected = i[k] == l.cells[k] ? l.upper[k] : l.lower[k] + extent * (double)i[k] / c;
        assert_true(x[p * dim + k] == expected);
      }
    }
    free(x);
  }
}

static void moves_interior_points_by_the_formula(void **state) {
  (void)state;
  for (int dim = 1; dim <= 3; dim++) {
    sct_lattice straight = lattice_of(dim, 0, 0), l = lattice_of(dim, 0.3, 12345);
    double *x0 = points_of(&straight), *x = points_of(&l);
    uint64_t inner = 0;
    for (int64_t p = 0; p < sct_lattice_count(&l); p++) {
      int64_t i[SCT_DIM_MAX];
      bool inside = place_of(&l, p, i);
      for (int k = 0; k < dim; k++) {
        double h = (l.upper[k] - l.lower[k]) / (double)l.cells[k], expected = x0[p * dim + k];
        if (inside) expected += 0.3 * (chi(12345, inner * (uint64_t)dim + (uint64_t)k) - 0.5) * h;
        assert_true(x[p * dim + k] == expected);
      }
      inner += inside;
    }
    assert_int_equal(inner, dim == 1 ? 5 : dim == 2 ? 15 : 30);
    free(x0);
    free(x);
  }
}

/* The first numbers of SplitMix64 for seed 1234567, as its authors' program prints them. */
static void generator_is_the_published_one(void **state) {
  (void)state;
  const uint64_t published[] = {6457827717110365317u, 3203168211198807973u, 9817491932198370423u,
                                4593380528125082431u, 16408922859458223821u};
  sct_lattice l = {1, {0}, {6}, {6}, 0.5, 1234567};
  double *x = points_of(&l);
  for (int m = 0; m < 5; m++) {
    double expected = (double)(published[m] >> 11) * 0x1p-53;
    assert_true(fabs((x[m + 1] - (m + 1)) / 0.5 + 0.5 - expected) < 1e-14);
  }
  free(x);
}

/* Neighbouring seeds have nothing to do with each other: no shifted copies, no correlation. */
static void seeds_differ(void **state) {
  (void)state;
  enum { N = 20000 };
  sct_lattice a = {1, {0}, {N + 1}, {N + 1}, 0.9, 1}, b = a;
  b.seed = 2;
  double *x = points_of(&a), *y = points_of(&b), mean = 0, square = 0;
  for (int shift = 0; shift < 3; shift++) {
    double product = 0;
    for (int i = 1; i + shift <= N; i++) {
      product += (x[i + shift] - i - shift) / 0.9 * ((y[i] - i) / 0.9);
    }
    assert_true(fabs(product / N) < 5.0 / 12 / sqrt(N)); /* five standard deviations */
  }
  for (int i = 1; i <= N; i++) mean += (x[i] - i) / 0.9 / N;
  for (int i = 1; i <= N; i++) square += pow((x[i] - i) / 0.9, 2) / N;
  assert_true(fabs(mean) < 5 * sqrt(1.0 / 12 / N));
  assert_true(fabs(square - 1.0 / 12) < 5 * sqrt(1.0 / 180 / N));
  free(x);
  free(y);
}

static void ends_are_exact(void **state) {
  (void)state;
  sct_lattice l = {1, {0.1}, {0.7}, {1000}, 0.99, 3};
  double *x = points_of(&l);
  assert_true(x[0] == 0.1 && x[1000] == 0.7);
  for (int i = 1; i <= 1000; i++) assert_true(x[i] > x[i - 1]);
  free(x);
}

static void spacing_is_step_or_mean(void **state) {
  (void)state;
  sct_lattice l = {3, {0, 0, 0}, {1, 1, 1}, {10, 10, 10}, 0, 0};
  assert_true(sct_lattice_spacing(&l) == 0.1);
  l.cells[1] = 20;
  l.cells[2] = 40;
  assert_true(fabs(sct_lattice_spacing(&l) - 0.05) < 1e-16);
  l.dim = 2;
  assert_true(fabs(sct_lattice_spacing(&l) - 0.1 / sqrt(2)) < 1e-16);
  sct_lattice huge = {3, {0, 0, 0}, {1e300, 1e300, 2e300}, {1, 1, 1}, 0, 0};
  assert_true(fabs(sct_lattice_spacing(&huge) / 1e300 - cbrt(2)) < 1e-13);
}

/* -- errors ------------------------------------------------------------------------------------ */

static void expect(sct_lattice l, sct_status status) {
  sct_error err;
  sct_group group;
  assert_int_equal(sct_lattice_check(&l, &err), status);
  assert_int_equal(sct_lattice_check(&l, NULL), status);
  if (status == SCT_OK) return;
  assert_int_equal(err.code, status);
  assert_true(strlen(err.text) > 0);
  assert_int_equal(sct_lattice_group(&l, SCT_SIDE_LEFT, &group, NULL), status);
  assert_null(group.index);
}

static void checks(void **state) {
  (void)state;
  const sct_lattice good = lattice_of(3, 0.3, 1);
  expect(good, SCT_OK);
  assert_int_equal(sct_lattice_check(NULL, NULL), SCT_E_ARGUMENT);
  const int dims[] = {0, 4, -1};
  for (int d = 0; d < 3; d++) {
    sct_lattice l = good;
    l.dim = dims[d];
    expect(l, SCT_E_ARGUMENT);
  }
  const double jitters[] = {-0.1, 1, NAN, INFINITY};
  for (int j = 0; j < 4; j++) {
    sct_lattice l = good;
    l.jitter = jitters[j];
    expect(l, SCT_E_ARGUMENT);
  }
  const double uppers[] = {2, 1, NAN, INFINITY};
  for (int u = 0; u < 4; u++) {
    sct_lattice l = good;
    l.lower[2] = u == 3 ? -INFINITY : 2;
    l.upper[2] = uppers[u];
    expect(l, SCT_E_ARGUMENT);
    l.dim = 2; /* the bad axis is not used */
    expect(l, SCT_OK);
  }
  sct_lattice wide = {1, {-1.5e308}, {1.5e308}, {1}, 0, 0};
  expect(wide, SCT_E_ARGUMENT);
}

static void counts_without_overflow(void **state) {
  (void)state;
  sct_lattice l = {3, {0, 0, 0}, {1, 1, 1}, {1289, 1289, 1289}, 0, 0};
  expect(l, SCT_OK);
  assert_int_equal(sct_lattice_count(&l), (int64_t)1290 * 1290 * 1290);
  const int64_t bad[][3] = {{1290, 1290, 1288},
                            {INT64_MAX, 1, 1},
                            {1, INT64_MAX, INT64_MAX},
                            {(int64_t)1 << 32, (int64_t)1 << 32, 1},
                            {SCT_POINTS_MAX, 1, 1}};
  for (size_t b = 0; b < sizeof bad / sizeof *bad; b++) {
    memcpy(l.cells, bad[b], sizeof l.cells);
    expect(l, SCT_E_LIMIT);
  }
  l.cells[0] = 0;
  expect(l, SCT_E_ARGUMENT);
  l.cells[0] = INT64_MIN;
  expect(l, SCT_E_ARGUMENT);
}

/* -- sides ------------------------------------------------------------------------------------- */

static void names_sides(void **state) {
  (void)state;
  for (int side = 0; side < SCT_SIDE_COUNT; side++) {
    assert_int_equal(sct_side_find(sct_side_name((sct_side)side)), side);
  }
  assert_string_equal(sct_side_name(SCT_SIDE_FRONT), "front");
  assert_null(sct_side_name(SCT_SIDE_COUNT));
  assert_int_equal(sct_side_find("inlet"), SCT_SIDE_COUNT);
  assert_int_equal(sct_side_find(""), SCT_SIDE_COUNT);
  assert_int_equal(sct_side_find(NULL), SCT_SIDE_COUNT);
}

/* Is point p on the side, and the outward normal there (boundary: of all its sides)? */
static bool on_side(const sct_lattice *l, sct_side side, int64_t p, double *normal) {
  int64_t i[SCT_DIM_MAX];
  bool inside = place_of(l, p, i), member = side == SCT_SIDE_BOUNDARY && !inside;
  for (int k = 0; k < l->dim; k++) {
    bool low = i[k] == 0, high = i[k] == l->cells[k];
    bool wanted = side == SCT_SIDE_BOUNDARY || (int)side / 2 == k;
    if (wanted && side != SCT_SIDE_BOUNDARY) {
      low = low && side % 2 == 0;
      high = high && side % 2 == 1;
      member = low || high;
    }
    normal[k] = wanted ? (double)high - (double)low : 0;
  }
  return side == SCT_SIDE_INTERIOR ? inside : member;
}

static void check_group(const sct_lattice *l, sct_side side) {
  sct_group g;
  sct_error err;
  if (sct_lattice_group(l, side, &g, &err) != SCT_OK) fail_msg("%s", err.text);
  assert_string_equal(g.name, sct_side_name(side));
  assert_int_equal(g.normals, side == SCT_SIDE_INTERIOR ? 0 : side == SCT_SIDE_BOUNDARY ? g.n : 1);
  assert_true((g.normal == NULL) == (side == SCT_SIDE_INTERIOR));
  int64_t m = 0;
  for (int64_t p = 0; p < sct_lattice_count(l); p++) {
    double sum[SCT_DIM_MAX], length = 0;
    if (!on_side(l, side, p, sum)) continue;
    assert_true(m < g.n);
    assert_int_equal(g.index[m], p);
    for (int k = 0; k < l->dim; k++) length += sum[k] * sum[k];
    for (int k = 0; k < l->dim && side != SCT_SIDE_INTERIOR; k++) {
      double normal = g.normal[(g.normals == 1 ? 0 : m) * l->dim + k];
      assert_true(fabs(normal - sum[k] / sqrt(length)) < 1e-15);
    }
    m++;
  }
  assert_int_equal(m, g.n);
  sct_group_clear(&g);
  assert_null(g.index);
  assert_null(g.normal);
  assert_int_equal(g.n, 0);
}

static void builds_groups(void **state) {
  (void)state;
  for (int dim = 1; dim <= 3; dim++) {
    for (int flat = 0; flat < 2; flat++) {
      sct_lattice l = lattice_of(dim, 0.5, 1);
      if (flat) l.cells[0] = 1; /* no interior */
      for (int side = 0; side < SCT_SIDE_COUNT; side++) {
        if (side >= 2 * dim && side < SCT_SIDE_BOUNDARY) continue;
        check_group(&l, (sct_side)side);
      }
    }
  }
}

static void rejects_sides_without_dimension(void **state) {
  (void)state;
  sct_group g;
  sct_error err;
  sct_lattice l = lattice_of(1, 0, 0);
  assert_int_equal(sct_lattice_group(&l, SCT_SIDE_BOTTOM, &g, &err), SCT_E_ARGUMENT);
  assert_non_null(strstr(err.text, "bottom"));
  l.dim = 2;
  assert_int_equal(sct_lattice_group(&l, SCT_SIDE_FRONT, &g, &err), SCT_E_ARGUMENT);
  assert_int_equal(sct_lattice_group(&l, SCT_SIDE_COUNT, &g, &err), SCT_E_ARGUMENT);
  assert_null(g.index);
  sct_group_clear(NULL);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(numbers_x_fastest),
      cmocka_unit_test(moves_interior_points_by_the_formula),
      cmocka_unit_test(generator_is_the_published_one),
      cmocka_unit_test(seeds_differ),
      cmocka_unit_test(ends_are_exact),
      cmocka_unit_test(spacing_is_step_or_mean),
      cmocka_unit_test(checks),
      cmocka_unit_test(counts_without_overflow),
      cmocka_unit_test(names_sides),
      cmocka_unit_test(builds_groups),
      cmocka_unit_test(rejects_sides_without_dimension),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
