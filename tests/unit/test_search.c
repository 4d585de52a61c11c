/* Every structure against brute force, on clouds that suit it and clouds that do not. */
#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "clouds.h"
#include "scatter/search.h"

static const sct_search_method methods[] = {SCT_SEARCH_GRID, SCT_SEARCH_TREE, SCT_SEARCH_AUTO};
enum { METHODS = sizeof methods / sizeof *methods };

/* -- the oracle ---------------------------------------------------------------------------------
 */

static double square(const sct_cloud *cloud, const double *x, int64_t j) {
  double d[SCT_DIM_MAX] = {0};
  for (int k = 0; k < cloud->dim; k++) d[k] = cloud->x[j * cloud->dim + k] - x[k];
  return d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
}

static double nearest(const sct_cloud *cloud, int64_t i) {
  double best = INFINITY;
  for (int64_t j = 0; j < cloud->n; j++) {
    if (j != i) best = fmin(best, square(cloud, cloud->x + i * cloud->dim, j));
  }
  return sqrt(best);
}

/* -- comparing ----------------------------------------------------------------------------------
 */

static sct_search *build(const sct_cloud *cloud, double radius, sct_search_method method) {
  sct_error err;
  sct_search *search = NULL;
  sct_status status = sct_search_build(cloud, radius, method, NULL, &search, &err);
  if (status != SCT_OK) fail_msg("%s", err.text);
  return search;
}

/* Is `index` [n] the set of all points within radius of x but `self`? */
static void same_set(const sct_cloud *cloud, const double *x, double radius, int64_t self,
                     const int32_t *index, int64_t n) {
  unsigned char *seen = calloc((size_t)cloud->n, 1);
  for (int64_t k = 0; k < n; k++) {
    assert_in_range(index[k], 0, cloud->n - 1);
    assert_int_equal(seen[index[k]]++, 0);
  }
  for (int64_t j = 0; j < cloud->n; j++) {
    assert_int_equal(seen[j], j != self && square(cloud, x, j) < radius * radius);
  }
  free(seen);
}

static void check_lists(const sct_cloud *cloud, const sct_search *search, double radius,
                        const double *radii) {
  sct_lists *lists = NULL;
  sct_error err;
  sct_work work = {.threads = 2};
  sct_status status = sct_search_lists(search, radius, radii, cloud->n, &work, &lists, &err);
  if (status != SCT_OK) fail_msg("%s", err.text);
  assert_int_equal(lists->n, cloud->n);
  assert_int_equal(lists->start[0], 0);
  for (int64_t i = 0; i < cloud->n; i++) {
    same_set(cloud, cloud->x + i * cloud->dim, radii != NULL ? radii[i] : radius, i,
             lists->index + lists->start[i], lists->start[i + 1] - lists->start[i]);
  }
  sct_lists_free(&lists);
  assert_null(lists);
}

static void check_nearest(const sct_cloud *cloud, const sct_search *search) {
  double *distance = malloc((size_t)cloud->n * sizeof *distance);
  assert_int_equal(sct_search_nearest(search, NULL, distance, NULL), SCT_OK);
  for (int64_t i = 0; i < cloud->n; i++) {
    double expected = nearest(cloud, i);
    if (distance[i] != expected)
      fail_msg("point %" PRId64 ": %g, not %g", i, distance[i], expected);
  }
  free(distance);
}

static void check_around(const sct_cloud *cloud, const sct_search *search, const double *x,
                         double radius) {
  int32_t *index = malloc((size_t)cloud->n * sizeof *index);
  int64_t n = sct_search_around(search, x, radius, cloud->n, index);
  assert_in_range(n, 0, cloud->n);
  same_set(cloud, x, radius, -1, index, n);
  index[n / 2] = -1;
  assert_int_equal(sct_search_around(search, x, radius, n / 2, index), n);
  if (n > 0) assert_int_equal(index[n / 2], -1);
  free(index);
}

/* -- the generic test ---------------------------------------------------------------------------
 */

/* All questions about one cloud, of spacing h, to one structure. */
static void check_all(const sct_cloud *cloud, double h, double hint, sct_search_method method) {
  const double factors[] = {0, 0.5, 2.1, 7, 1e9};
  sct_search *search = build(cloud, hint, method);
  for (size_t f = 0; f < sizeof factors / sizeof *factors; f++) {
    check_lists(cloud, search, factors[f] * h, NULL);
    check_around(cloud, search, cloud->x, factors[f] * h);
    double outside[SCT_DIM_MAX] = {cloud->x[0] + 3 * h, cloud->x[0] - 1.5 * h, 1e3 * h};
    check_around(cloud, search, outside, factors[f] * h);
  }
  double *radii = malloc((size_t)cloud->n * sizeof *radii);
  for (int64_t i = 0; i < cloud->n; i++) radii[i] = h * (double)(i % 7) * (i % 50 == 0 ? 10 : 0.5);
  check_lists(cloud, search, 0, radii);
  free(radii);
  check_nearest(cloud, search);
  sct_search_free(&search);
  assert_null(search);
}

static void every_cloud(void **state) {
  (void)state;
  for (int kind = 0; kind < CLOUDS; kind++) {
    for (int dim = 1; dim <= 3; dim++) {
      uint64_t seed = (uint64_t)(100 * kind + dim);
      sct_cloud cloud = cloud_make(kind, dim, 400, seed);
      double h = pow(1.0 / 400, 1.0 / dim);
      print_message("%s, %d-D, seed %" PRIu64 "\n", cloud_names[kind], dim, seed);
      for (int m = 0; m < METHODS; m++) {
        check_all(&cloud, h, m == 0 ? 0 : 2.1 * h, methods[m]);
      }
      cloud_free(&cloud);
    }
  }
}

/* Few points: every number from one on, so that leaves and cells come in every filling. */
static void every_small_number(void **state) {
  (void)state;
  for (int64_t n = 1; n <= 40; n++) {
    for (int dim = 1; dim <= 3; dim++) {
      sct_cloud cloud = cloud_make(CLOUD_UNIFORM, dim, n, (uint64_t)n);
      for (int m = 0; m < METHODS; m++) check_all(&cloud, 0.3, 0, methods[m]);
      cloud_free(&cloud);
    }
  }
}

/* More neighbours than are tested at a time. */
static void crowds(void **state) {
  (void)state;
  const int kinds[] = {CLOUD_UNIFORM, CLOUD_SPECK, CLOUD_LINE};
  for (int k = 0; k < 3; k++) {
    sct_cloud cloud = cloud_make(kinds[k], 3, 2600, 5);
    for (int m = 0; m < METHODS; m++) {
      sct_search *search = build(&cloud, 0, methods[m]);
      check_lists(&cloud, search, 0.8, NULL);
      check_around(&cloud, search, cloud.x + 30, 0.8);
      check_nearest(&cloud, search);
      sct_search_free(&search);
    }
    cloud_free(&cloud);
  }
}

/* A neighbour at the radius is none. */
static void is_strict(void **state) {
  (void)state;
  const int64_t within_two[] = {2, 8, 26};
  for (int dim = 1; dim <= 3; dim++) {
    sct_lattice l = {dim, {0, 0, 0}, {6, 6, 6}, {6, 6, 6}, 0, 0};
    double x[343 * 3];
    sct_lattice_points(&l, x);
    sct_cloud cloud = {dim, sct_lattice_count(&l), x};
    for (int m = 0; m < METHODS; m++) {
      sct_search *search = build(&cloud, 2, methods[m]);
      sct_lists *lists;
      assert_int_equal(sct_search_lists(search, 2, NULL, 100, NULL, &lists, NULL), SCT_OK);
      int64_t middle = cloud.n / 2;
      assert_int_equal(lists->start[middle + 1] - lists->start[middle], within_two[dim - 1]);
      sct_lists_free(&lists);
      sct_search_free(&search);
    }
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_cloud),
      cmocka_unit_test(every_small_number),
      cmocka_unit_test(crowds),
      cmocka_unit_test(is_strict),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
