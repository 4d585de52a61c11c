/* What the search does at its edges: arguments, limits, threads, coincident points, boxes without
 * an inside, lengths near the ends of double precision. */
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

static sct_search *build(const sct_cloud *cloud, sct_search_method method) {
  sct_error err;
  sct_search *search = NULL;
  if (sct_search_build(cloud, 0, method, NULL, &search, &err) != SCT_OK) fail_msg("%s", err.text);
  return search;
}

static sct_lists *lists_of(const sct_search *search, double radius, int threads) {
  sct_error err;
  sct_work work = {.threads = threads};
  sct_lists *lists = NULL;
  if (sct_search_lists(search, radius, NULL, INT32_MAX, &work, &lists, &err) != SCT_OK) {
    fail_msg("%s", err.text);
  }
  return lists;
}

static void assert_same_lists(const sct_lists *a, const sct_lists *b) {
  assert_int_equal(a->n, b->n);
  assert_memory_equal(a->start, b->start, (size_t)(a->n + 1) * sizeof *a->start);
  assert_memory_equal(a->index, b->index, (size_t)a->start[a->n] * sizeof *a->index);
}

/* -- arguments --------------------------------------------------------------------------------- */

static void rejects_builds(void **state) {
  (void)state;
  const double x[] = {0, 1, NAN, 3};
  const struct {
    sct_cloud cloud;
    double radius;
    int method;
    sct_status status;
    int64_t point;
  } cases[] = {
      {{1, 4, x}, 0, SCT_SEARCH_AUTO, SCT_E_NOT_FINITE, 2},
      {{5, 2, x}, 0, SCT_SEARCH_AUTO, SCT_E_ARGUMENT, -1},
      {{1, 2, x}, -1, SCT_SEARCH_AUTO, SCT_E_ARGUMENT, -1},
      {{1, 2, x}, NAN, SCT_SEARCH_AUTO, SCT_E_ARGUMENT, -1},
      {{1, 2, x}, 0, SCT_SEARCH_COUNT, SCT_E_ARGUMENT, -1},
      {{1, 2, x}, 0, -1, SCT_E_ARGUMENT, -1},
      {{1, SCT_POINTS_MAX + 1, x}, 0, SCT_SEARCH_AUTO, SCT_E_LIMIT, -1},
  };
  for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
    sct_search *search = (sct_search *)1;
    sct_error err;
    sct_search_method method = (sct_search_method)cases[c].method;
    assert_int_equal(
        sct_search_build(&cases[c].cloud, cases[c].radius, method, NULL, &search, &err),
        cases[c].status);
    assert_null(search);
    assert_int_equal(err.point, cases[c].point);
  }
}

static void rejects_radii(void **state) {
  (void)state;
  const double x[] = {0, 1, 3}, radii[] = {1, 2, -1}, nan_radii[] = {1, NAN, 0};
  sct_search *search = build(&(sct_cloud){1, 3, x}, SCT_SEARCH_AUTO);
  sct_lists *lists = (sct_lists *)1;
  sct_error err;
  assert_int_equal(sct_search_lists(search, -1, NULL, 9, NULL, &lists, &err), SCT_E_ARGUMENT);
  assert_null(lists);
  assert_int_equal(sct_search_lists(search, NAN, NULL, 9, NULL, &lists, NULL), SCT_E_ARGUMENT);
  assert_int_equal(sct_search_lists(search, 1, radii, 9, NULL, &lists, &err), SCT_E_ARGUMENT);
  assert_int_equal(err.point, 2);
  assert_int_equal(sct_search_lists(search, 1, nan_radii, 9, NULL, &lists, &err), SCT_E_ARGUMENT);
  assert_int_equal(err.point, 1);
  int32_t index[3];
  assert_int_equal(sct_search_around(search, x, NAN, 3, index), 0);
  assert_int_equal(sct_search_around(search, x, -1, 3, index), 0);
  assert_int_equal(sct_search_around(search, (double[]){NAN}, 5, 3, index), 0);
  assert_int_equal(sct_search_around(search, (double[]){INFINITY}, 5, 3, index), 0);
  assert_int_equal(sct_search_around(search, (double[]){1e308}, 5, 3, index), 0);
  assert_int_equal(sct_search_around(search, x, INFINITY, 3, index), 3);
  assert_int_equal(sct_search_around(search, x, INFINITY, 0, NULL), 3);
  sct_search_free(&search);
  sct_search_free(&search);
  sct_search_free(NULL);
  sct_lists_free(NULL);
}

static void names_methods(void **state) {
  (void)state;
  assert_string_equal(sct_search_method_name(SCT_SEARCH_AUTO), "auto");
  assert_string_equal(sct_search_method_name(SCT_SEARCH_GRID), "grid");
  assert_string_equal(sct_search_method_name(SCT_SEARCH_TREE), "tree");
  assert_null(sct_search_method_name(SCT_SEARCH_COUNT));
}

/* Cells for what they can hold, the tree for what they cannot. */
static void chooses(void **state) {
  (void)state;
  const sct_search_method expected[CLOUDS] = {
      [CLOUD_UNIFORM] = SCT_SEARCH_GRID,   [CLOUD_LATTICE] = SCT_SEARCH_GRID,
      [CLOUD_CLUSTERED] = SCT_SEARCH_TREE, [CLOUD_GRADED] = SCT_SEARCH_TREE,
      [CLOUD_LINE] = SCT_SEARCH_TREE,      [CLOUD_PLANE] = SCT_SEARCH_GRID,
      [CLOUD_OUTLIER] = SCT_SEARCH_TREE,   [CLOUD_SPECK] = SCT_SEARCH_GRID};
  for (int kind = 0; kind < CLOUDS; kind++) {
    sct_cloud cloud = cloud_make(kind, 3, 20000, 3);
    for (int m = 0; m < METHODS; m++) {
      sct_search *search = build(&cloud, methods[m]);
      sct_search_method kept = methods[m] == SCT_SEARCH_AUTO ? expected[kind] : methods[m];
      if (sct_search_kind(search) != kept) fail_msg("%s", cloud_names[kind]);
      sct_search_free(&search);
    }
    cloud_free(&cloud);
  }
}

/* -- limits ------------------------------------------------------------------------------------ */

/* Point 30 of a row of spacing 1 has a crowd of its own. */
static void limits_name_the_point(void **state) {
  (void)state;
  double x[100];
  for (int i = 0; i < 100; i++) x[i] = i < 80 ? i : 30 + 0.001 * (i - 79);
  for (int m = 0; m < METHODS; m++) {
    sct_search *search = build(&(sct_cloud){1, 100, x}, methods[m]);
    for (int threads = 1; threads <= 3; threads++) {
      sct_work work = {.threads = threads};
      sct_lists *lists = (sct_lists *)1;
      sct_error err;
      assert_int_equal(sct_search_lists(search, 0.5, NULL, 20, &work, &lists, &err), SCT_OK);
      sct_lists_free(&lists);
      assert_int_equal(sct_search_lists(search, 0.5, NULL, 19, &work, &lists, &err), SCT_E_LIMIT);
      assert_null(lists);
      assert_int_equal(err.point, 30);
      assert_non_null(strstr(err.text, "19"));
      assert_int_equal(sct_search_lists(search, 0.5, NULL, 0, &work, &lists, NULL), SCT_E_LIMIT);
      assert_int_equal(sct_search_lists(search, 0.5, NULL, -5, &work, &lists, NULL), SCT_E_LIMIT);
      assert_int_equal(sct_search_lists(search, 0, NULL, 0, &work, &lists, NULL), SCT_OK);
      assert_int_equal(lists->start[100], 0);
      sct_lists_free(&lists);
    }
    sct_search_free(&search);
  }
}

/* 1e5 points at one place and nearly so: 1e10 pairs that nobody may look at. */
static void crowds_end_early(void **state) {
  (void)state;
  enum { N = 100000 };
  double *x = calloc(3 * N, sizeof *x), *distance = malloc(N * sizeof *distance);
  sct_search *search = build(&(sct_cloud){3, N, x}, SCT_SEARCH_AUTO);
  sct_lists *lists;
  sct_error err;
  assert_int_equal(sct_search_lists(search, 1, NULL, 1000, NULL, &lists, &err), SCT_E_LIMIT);
  assert_int_equal(sct_search_nearest(search, NULL, distance, &err), SCT_E_COINCIDENT);
  assert_int_equal(err.count, N);
  for (int k = 0; k < SCT_ERROR_POINTS; k++) assert_int_equal(err.points[k], k);
  sct_search_free(&search);
  uint64_t stream = 1;
  for (int e = 0; e < 3 * N; e++) x[e] = (e < 3 ? 1 : 1e-9) * cloud_random(&stream);
  search = build(&(sct_cloud){3, N, x}, SCT_SEARCH_AUTO);
  assert_int_equal(sct_search_lists(search, 0.1, NULL, 1000, NULL, &lists, &err), SCT_E_LIMIT);
  assert_int_equal(sct_search_nearest(search, NULL, distance, &err), SCT_OK);
  sct_search_free(&search);
  free(x);
  free(distance);
}

/* -- coincident points ------------------------------------------------------------------------- */

static void finds_coincident_points(void **state) {
  (void)state;
  for (int kind = 0; kind < CLOUDS; kind++) {
    sct_cloud cloud = cloud_make(kind, 2, 3000, 17);
    double *x = (double *)(uintptr_t)cloud.x, *distance = malloc((size_t)cloud.n * sizeof *x);
    const int64_t copies[][2] = {{70, 2500}, {1200, 900}, {1201, 900}};
    for (int c = 0; c < 3; c++) memcpy(x + 2 * copies[c][0], x + 2 * copies[c][1], 2 * sizeof *x);
    for (int m = 0; m < METHODS; m++) {
      sct_search *search = build(&cloud, methods[m]);
      sct_error err;
      const int64_t expected[] = {70, 2500, 900, 1200, 1201};
      assert_int_equal(sct_search_nearest(search, NULL, distance, NULL), SCT_E_COINCIDENT);
      assert_int_equal(sct_search_nearest(search, NULL, distance, &err), SCT_E_COINCIDENT);
      assert_int_equal(err.point, 70);
      assert_int_equal(err.count, 5);
      assert_memory_equal(err.points, expected, sizeof expected);
      for (int k = 0; k < 5; k++) assert_true(distance[expected[k]] == 0);
      sct_search_free(&search);
    }
    free(distance);
    cloud_free(&cloud);
  }
}

static void single_point_is_alone(void **state) {
  (void)state;
  const double x[3] = {1, 2, 3};
  for (int m = 0; m < METHODS; m++) {
    sct_search *search = build(&(sct_cloud){3, 1, x}, methods[m]);
    double distance = 0;
    assert_int_equal(sct_search_nearest(search, NULL, &distance, NULL), SCT_OK);
    assert_true(distance == INFINITY);
    sct_lists *lists = lists_of(search, 1e9, 2);
    assert_int_equal(lists->start[1], 0);
    sct_lists_free(&lists);
    sct_search_free(&search);
  }
}

/* -- threads ----------------------------------------------------------------------------------- */

static void threads_change_nothing(void **state) {
  (void)state;
  const int kinds[] = {CLOUD_UNIFORM, CLOUD_GRADED};
  for (int k = 0; k < 2; k++) {
    sct_cloud cloud = cloud_make(kinds[k], 2, 150000, 23);
    sct_search *search = build(&cloud, SCT_SEARCH_AUTO);
    double radius = kinds[k] == CLOUD_UNIFORM ? 0.004 : 1e-9;
    sct_lists *one = lists_of(search, radius, 1);
    double *distance = malloc(2 * (size_t)cloud.n * sizeof *distance);
    assert_true(one->start[one->n] > 1000);
    for (int threads = 2; threads <= 5; threads += 3) {
      sct_work work = {.threads = threads};
      sct_lists *many = lists_of(search, radius, threads);
      assert_same_lists(one, many);
      sct_lists_free(&many);
      assert_int_equal(sct_search_nearest(search, NULL, distance, NULL), SCT_OK);
      assert_int_equal(sct_search_nearest(search, &work, distance + cloud.n, NULL), SCT_OK);
      assert_memory_equal(distance, distance + cloud.n, (size_t)cloud.n * sizeof *distance);
    }
    sct_lists_free(&one);
    free(distance);
    sct_search_free(&search);
    cloud_free(&cloud);
  }
}

/* -- reports ----------------------------------------------------------------------------------- */

typedef struct {
  int calls, last;
} patience;

static bool hear(void *context, const char *phase, double fraction) {
  patience *p = context;
  assert_non_null(phase);
  assert_true(fraction >= 0 && fraction <= 1);
  return ++p->calls != p->last;
}

/* Whoever asks for the end at whichever report gets it. */
static void ends_when_told(void **state) {
  (void)state;
  sct_cloud cloud = cloud_make(CLOUD_UNIFORM, 1, 300000, 1);
  double *distance = malloc((size_t)cloud.n * sizeof *distance);
  sct_status status = SCT_E_CANCELLED;
  int last = 1;
  for (; status == SCT_E_CANCELLED; last++) {
    patience p = {0, last};
    sct_work work = {.threads = 2, .report = hear, .context = &p};
    sct_search *search = NULL;
    sct_lists *lists = NULL;
    sct_error err;
    status = sct_search_build(&cloud, 0, SCT_SEARCH_AUTO, &work, &search, &err);
    if (status == SCT_OK) status = sct_search_nearest(search, &work, distance, &err);
    if (status == SCT_OK) status = sct_search_lists(search, 1e-5, NULL, 99, &work, &lists, &err);
    assert_true(status == SCT_OK || (lists == NULL && err.code == status));
    assert_true(status == SCT_OK || p.calls == last);
    sct_lists_free(&lists);
    sct_search_free(&search);
  }
  assert_int_equal(status, SCT_OK);
  assert_true(last > 6);
  free(distance);
  cloud_free(&cloud);
}

/* -- extremes ---------------------------------------------------------------------------------- */

/* A power of two as a factor of all lengths changes no answer, even where no square of a length
 * is a number any more. */
static void scale_changes_nothing(void **state) {
  (void)state;
  for (int kind = 0; kind < CLOUDS; kind++) {
    sct_cloud cloud = cloud_make(kind, 2, 2000, 29);
    double *x = malloc(2 * (size_t)cloud.n * sizeof *x);
    double *distance = malloc(2 * (size_t)cloud.n * sizeof *x), *scaled = distance + cloud.n;
    for (int m = 0; m < METHODS; m++) {
      sct_search *search = build(&cloud, methods[m]);
      sct_lists *lists = lists_of(search, 0.05, 1);
      assert_int_equal(sct_search_nearest(search, NULL, distance, NULL), SCT_OK);
      for (int power = -880; power <= 880; power += 160) {
        for (int64_t e = 0; e < 2 * cloud.n; e++) x[e] = ldexp(cloud.x[e], power);
        sct_search *other = build(&(sct_cloud){2, cloud.n, x}, methods[m]);
        sct_lists *same = lists_of(other, ldexp(0.05, power), 1);
        assert_same_lists(lists, same);
        assert_int_equal(sct_search_nearest(other, NULL, scaled, NULL), SCT_OK);
        for (int64_t i = 0; i < cloud.n; i++) assert_true(scaled[i] == ldexp(distance[i], power));
        int32_t a[2000], b[2000];
        int64_t n = sct_search_around(search, cloud.x + 10, 0.05, 2000, a);
        assert_int_equal(sct_search_around(other, x + 10, ldexp(0.05, power), 2000, b), n);
        assert_memory_equal(a, b, (size_t)n * sizeof *a);
        sct_lists_free(&same);
        sct_search_free(&other);
      }
      sct_lists_free(&lists);
      sct_search_free(&search);
    }
    free(x);
    free(distance);
    cloud_free(&cloud);
  }
}

/* Boxes that are flat, long, or as wide as numbers go: built, and right about two points. */
static void odd_boxes(void **state) {
  (void)state;
  const double sizes[] = {0, 5e-324, 1e-300, 1e-10, 1, 1e10, 1.7e308};
  enum { SIZES = sizeof sizes / sizeof *sizes, N = 60 };
  for (int box = 0; box < SIZES * SIZES * SIZES; box++) {
    const double side[] = {sizes[box % SIZES], sizes[box / SIZES % SIZES],
                           sizes[box / SIZES / SIZES]};
    double x[3 * N], distance[N];
    uint64_t stream = 31;
    for (int e = 0; e < 3 * N; e++) x[e] = side[e % 3] * (2 * cloud_random(&stream) - 1);
    for (int m = 0; m < METHODS; m++) {
      sct_search *search = build(&(sct_cloud){3, N, x}, methods[m]);
      sct_status status = sct_search_nearest(search, NULL, distance, NULL);
      assert_true(status == SCT_OK || status == SCT_E_COINCIDENT);
      sct_lists *lists = lists_of(search, INFINITY, 1);
      assert_int_equal(lists->start[N], (int64_t)N * (N - 1));
      sct_lists_free(&lists);
      lists = lists_of(search, 0, 1);
      assert_int_equal(lists->start[N], 0);
      sct_lists_free(&lists);
      sct_search_free(&search);
    }
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(rejects_builds),          cmocka_unit_test(rejects_radii),
      cmocka_unit_test(names_methods),           cmocka_unit_test(chooses),
      cmocka_unit_test(limits_name_the_point),   cmocka_unit_test(crowds_end_early),
      cmocka_unit_test(finds_coincident_points), cmocka_unit_test(single_point_is_alone),
      cmocka_unit_test(threads_change_nothing),  cmocka_unit_test(ends_when_told),
      cmocka_unit_test(scale_changes_nothing),   cmocka_unit_test(odd_boxes),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
