#include <inttypes.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "clouds.h"
#include "radix.h"

/* -- check ------------------------------------------------------------------------------------- */

static void expect(const sct_cloud *cloud, sct_status status, int64_t point) {
  sct_error err = {.point = -1};
  assert_int_equal(sct_cloud_check(cloud, &err), status);
  assert_int_equal(sct_cloud_check(cloud, NULL), status);
  if (status == SCT_OK) return;
  assert_int_equal(err.code, status);
  assert_int_equal(err.point, point);
  assert_true(strlen(err.text) > 0);
}

static void accepts(void **state) {
  (void)state;
  const double x[6] = {0, 1, -1e308, 1e308, -0.0, 5e-324};
  for (int dim = 1; dim <= 3; dim++) expect(&(sct_cloud){dim, 6 / dim, x}, SCT_OK, -1);
}

static void rejects_shape(void **state) {
  (void)state;
  const double x[4] = {0, 1, 2, 3};
  expect(NULL, SCT_E_ARGUMENT, -1);
  expect(&(sct_cloud){0, 4, x}, SCT_E_ARGUMENT, -1);
  expect(&(sct_cloud){4, 1, x}, SCT_E_ARGUMENT, -1);
  expect(&(sct_cloud){1, 0, x}, SCT_E_ARGUMENT, -1);
  expect(&(sct_cloud){1, -1, x}, SCT_E_ARGUMENT, -1);
  expect(&(sct_cloud){1, 4, NULL}, SCT_E_ARGUMENT, -1);
  expect(&(sct_cloud){1, SCT_POINTS_MAX + 1, x}, SCT_E_LIMIT, -1);
  expect(&(sct_cloud){1, INT64_MAX, x}, SCT_E_LIMIT, -1);
}

static void names_first_culprit(void **state) {
  (void)state;
  const double bad[] = {NAN, INFINITY, -INFINITY};
  for (size_t b = 0; b < sizeof bad / sizeof *bad; b++) {
    double x[12] = {0};
    x[7] = bad[b];
    x[10] = NAN;
    expect(&(sct_cloud){1, 12, x}, SCT_E_NOT_FINITE, 7);
    expect(&(sct_cloud){2, 6, x}, SCT_E_NOT_FINITE, 3);
    expect(&(sct_cloud){3, 4, x}, SCT_E_NOT_FINITE, 2);
  }
}

/* -- order ------------------------------------------------------------------------------------- */

static int32_t *order_of(const sct_cloud *cloud) {
  int32_t *order = malloc((size_t)cloud->n * sizeof *order);
  unsigned char *seen = calloc((size_t)cloud->n, 1);
  sct_error err;
  if (sct_cloud_order(cloud, order, &err) != SCT_OK) fail_msg("%s", err.text);
  for (int64_t k = 0; k < cloud->n; k++) {
    assert_in_range(order[k], 0, cloud->n - 1);
    assert_int_equal(seen[order[k]]++, 0);
  }
  free(seen);
  return order;
}

static double distance(const sct_cloud *cloud, int64_t i, int64_t j) {
  double sum = 0;
  for (int k = 0; k < cloud->dim; k++) {
    double d = cloud->x[i * cloud->dim + k] - cloud->x[j * cloud->dim + k];
    sum += d * d;
  }
  return sqrt(sum);
}

/* What makes the curve a Hilbert curve: on all cells of a cube it goes from neighbour to
 * neighbour. 2^b points per side fall into cells of their own, middle by middle. */
static void goes_from_neighbour_to_neighbour(void **state) {
  (void)state;
  for (int dim = 1; dim <= 3; dim++) {
    sct_lattice l = {dim, {0, 0, 0}, {15, 15, 15}, {15, 15, 15}, 0, 0};
    sct_cloud cloud = {dim, sct_lattice_count(&l), NULL};
    double *x = malloc((size_t)(cloud.n * dim) * sizeof *x);
    sct_lattice_points(&l, x);
    cloud.x = x;
    int32_t *order = order_of(&cloud);
    for (int64_t k = 1; k < cloud.n; k++) {
      assert_true(distance(&cloud, order[k - 1], order[k]) == 1);
    }
    free(order);
    free(x);
  }
}

static void orders_every_cloud(void **state) {
  (void)state;
  for (int kind = 0; kind < CLOUDS; kind++) {
    for (int dim = 1; dim <= 3; dim++) {
      sct_cloud cloud = cloud_make(kind, dim, 1000, 7);
      int32_t *order = order_of(&cloud), *again = order_of(&cloud);
      assert_memory_equal(order, again, (size_t)cloud.n * sizeof *order);
      free(order);
      free(again);
      cloud_free(&cloud);
    }
  }
}

/* A random cloud's mean step is a fraction of the random order's. */
static void shortens_the_way(void **state) {
  (void)state;
  for (int dim = 1; dim <= 3; dim++) {
    sct_cloud cloud = cloud_make(CLOUD_UNIFORM, dim, 4000, 11);
    int32_t *order = order_of(&cloud);
    double way = 0, random_way = 0;
    for (int64_t k = 1; k < cloud.n; k++) {
      way += distance(&cloud, order[k - 1], order[k]);
      random_way += distance(&cloud, k - 1, k);
    }
    assert_true(way < 0.2 * random_way);
    free(order);
    cloud_free(&cloud);
  }
}

static void orders_extremes(void **state) {
  (void)state;
  const double huge[] = {-1.7e308, 1.7e308, 0, 1e308}, tiny[] = {5e-324, 0, 1e-320, 2e-310};
  const double same[] = {3, 3, 3, 3};
  const int32_t ascending[] = {0, 2, 3, 1}, of_tiny[] = {1, 0, 2, 3}, of_same[] = {0, 1, 2, 3};
  int32_t *order = order_of(&(sct_cloud){1, 4, huge});
  assert_memory_equal(order, ascending, sizeof ascending);
  free(order);
  order = order_of(&(sct_cloud){1, 4, tiny});
  assert_int_equal(order[3], of_tiny[3]);
  free(order);
  order = order_of(&(sct_cloud){1, 4, same});
  assert_memory_equal(order, of_same, sizeof of_same);
  free(order);
  free(order_of(&(sct_cloud){2, 2, huge}));
  free(order_of(&(sct_cloud){3, 1, huge}));
  sct_error err;
  const double bad[] = {0, NAN};
  assert_int_equal(sct_cloud_order(&(sct_cloud){1, 2, bad}, NULL, &err), SCT_E_NOT_FINITE);
  assert_int_equal(err.point, 1);
}

/* -- radix ------------------------------------------------------------------------------------- */

static void sorts_stably(void **state) {
  (void)state;
  enum { N = 5000 };
  static uint64_t key[N], copy[N];
  static int32_t order[N];
  uint64_t stream = 5;
  for (int bits = 1; bits <= 64; bits += 7) {
    for (int k = 0; k < N; k++) {
      copy[k] = (uint64_t)(cloud_random(&stream) * 0x1p32) << 32 | (uint64_t)(k % 97);
      copy[k] = key[k] = bits == 64 ? copy[k] : copy[k] >> (64 - bits);
    }
    assert_int_equal(sct_radix_sort(key, N, bits, order, NULL), SCT_OK);
    for (int k = 0; k < N; k++) assert_true(key[k] == copy[order[k]]);
    for (int k = 1; k < N; k++) {
      assert_true(key[k - 1] < key[k] || (key[k - 1] == key[k] && order[k - 1] < order[k]));
    }
  }
}

static void keys_sort_like_values(void **state) {
  (void)state;
  const double ascending[] = {-INFINITY, -1e308, -1, -5e-324, -0.0, 0, 5e-324, 1, 1e308, INFINITY};
  for (size_t k = 0; k < sizeof ascending / sizeof *ascending; k++) {
    uint64_t key = sct_radix_key(ascending[k]);
    double back = sct_radix_value(key);
    assert_memory_equal(&back, &ascending[k], sizeof back);
    if (k > 0) assert_true(sct_radix_key(ascending[k - 1]) < key);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(accepts),
      cmocka_unit_test(rejects_shape),
      cmocka_unit_test(names_first_culprit),
      cmocka_unit_test(goes_from_neighbour_to_neighbour),
      cmocka_unit_test(orders_every_cloud),
      cmocka_unit_test(shortens_the_way),
      cmocka_unit_test(orders_extremes),
      cmocka_unit_test(sorts_stably),
      cmocka_unit_test(keys_sort_like_values),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
