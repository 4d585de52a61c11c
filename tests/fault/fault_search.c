/* Clouds and search with the n-th allocation failing, for every n: SCT_E_MEMORY, no output, no
 * leak (with -DSCATTERD_SANITIZE=ON). */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "clouds.h"
#include "fail_each.h"
#include "radix.h"
#include "scarce.h"
#include "scatter/search.h"

/* More than one piece of work, so that buffers have to grow. */
enum { N = 3000 };
static sct_cloud cloud;
static sct_search *search;

static sct_status order(sct_error *err) {
  static int32_t place[N];
  return sct_cloud_order(&cloud, place, err);
}

static sct_status sort(sct_error *err) {
  static uint64_t key[N];
  static int32_t place[N];
  for (int k = 0; k < N; k++) key[k] = (uint64_t)(k * 7919 % N);
  return sct_radix_sort(key, N, 12, place, err);
}

static sct_status group(sct_error *err) {
  sct_lattice l = {2, {0, 0}, {1, 1}, {9, 9}, 0.3, 1};
  sct_group g;
  sct_status status = sct_lattice_group(&l, SCT_SIDE_BOUNDARY, &g, err);
  assert_true((g.index != NULL) == (status == SCT_OK));
  assert_true((g.normal != NULL) == (status == SCT_OK));
  sct_group_clear(&g);
  return status;
}

static sct_status build(sct_search_method method, sct_error *err) {
  sct_search *built = (sct_search *)1;
  sct_status status = sct_search_build(&cloud, 0, method, NULL, &built, err);
  assert_true((built != NULL) == (status == SCT_OK));
  sct_search_free(&built);
  return status;
}

static sct_status build_grid(sct_error *err) {
  return build(SCT_SEARCH_GRID, err);
}

static sct_status build_tree(sct_error *err) {
  return build(SCT_SEARCH_TREE, err);
}

static sct_status build_auto(sct_error *err) {
  return build(SCT_SEARCH_AUTO, err);
}

static sct_status lists_by(int threads, sct_error *err) {
  sct_work work = {.threads = threads};
  sct_lists *lists = (sct_lists *)1;
  sct_status status = sct_search_lists(search, 0.2, NULL, N, &work, &lists, err);
  assert_true((lists != NULL) == (status == SCT_OK));
  sct_lists_free(&lists);
  return status;
}

static sct_status lists(sct_error *err) {
  return lists_by(1, err);
}

static sct_status lists_of_two(sct_error *err) {
  return lists_by(2, err);
}

static sct_status nearest(sct_error *err) {
  static double distance[N];
  return sct_search_nearest(search, NULL, distance, err);
}

/* What never allocates does not fail. */
static void works_without_memory(void **state) {
  (void)state;
  static int32_t index[N];
  static double value[N];
  double median;
  scarce_after(0, true);
  int64_t n = sct_search_around(search, cloud.x, 0.2, N, index);
  sct_status status = sct_median(value, N, &median, NULL);
  assert_false(scarce_end());
  assert_true(n > 1);
  assert_int_equal(status, SCT_OK);
}

static void clouds_fail(void **state) {
  (void)state;
  fail_each(order, 3);
  fail_each(sort, 2);
  fail_each(group, 2);
}

static void builds_fail(void **state) {
  (void)state;
  fail_each(build_grid, 5);
  fail_each(build_tree, 9);
  sct_cloud even = cloud;
  cloud = cloud_make(CLOUD_OUTLIER, 3, N, 1); /* from cells to tree */
  fail_each(build_auto, 14);
  cloud_free(&cloud);
  cloud = even;
}

static void questions_fail(void **state) {
  (void)state;
  fail_each(lists, 6);
  fail_each(lists_of_two, 6);
  fail_each(nearest, 1);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(works_without_memory),
      cmocka_unit_test(clouds_fail),
      cmocka_unit_test(builds_fail),
      cmocka_unit_test(questions_fail),
  };
  cloud = cloud_make(CLOUD_UNIFORM, 3, N, 1);
  if (sct_search_build(&cloud, 0, SCT_SEARCH_AUTO, NULL, &search, NULL) != SCT_OK) return 1;
  int failed = cmocka_run_group_tests(tests, NULL, NULL);
  sct_search_free(&search);
  cloud_free(&cloud);
  return failed;
}
