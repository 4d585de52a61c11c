/* Every allocation of a flow fails once, those of CHOLMOD too: the answer is SCT_E_MEMORY and
 * nothing leaks; without failure it is always the same flow. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <suitesparse/SuiteSparse_config.h>

#include "scarce.h"
#include "scatter/flow_case.h"

static int packages_fail_too(void **state) {
  (void)state;
  SuiteSparse_config.malloc_func = malloc;
  SuiteSparse_config.calloc_func = calloc;
  SuiteSparse_config.realloc_func = realloc;
  return 0;
}

/* A short flow with everything: inflow, images, a scalar, a snapshot, its state saved and loaded.
 */
static sct_status flow(int walls, sct_error *err) {
  static const double save[] = {0.1};
  sct_flow_case c;
  sct_flow *f = NULL, *g = NULL;
  void *bytes = NULL;
  size_t size;
  sct_status status = sct_flow_step(4, 100, 0.3, 2, SCT_IPS, 0.3, &c, err);
  if (status != SCT_OK) goto done;
  c.options.walls = (sct_flow_walls)walls;
  c.options.samples = 3;
  c.options.save = save;
  c.options.saves = 1;
  c.options.has_scalar = true;
  status = sct_flow_build(&c.domain, &c.options, &f, err);
  if (status == SCT_OK) status = sct_flow_advance(f, INT64_MAX, NULL, err);
  if (status == SCT_OK) status = sct_flow_save(f, &bytes, &size, err);
  if (status == SCT_OK) status = sct_flow_build(&c.domain, &c.options, &g, err);
  if (status == SCT_OK) status = sct_flow_load(g, bytes, size, err);
done:
  free(bytes);
  sct_flow_free(&f);
  sct_flow_free(&g);
  sct_flow_case_clear(&c);
  return status;
}

static void flows(void **state) {
  (void)state;
  for (int walls = 0; walls < SCT_FLOW_WALLS_COUNT; walls++) {
    int failures = 0;
    assert_int_equal(flow(walls, NULL), SCT_OK);
    for (int64_t n = 0;; n++) {
      sct_error err = {0};
      scarce_after(n, false);
      const sct_status status = flow(walls, &err);
      const bool hit = scarce_end();
      if (!hit) break;
      if (status == SCT_OK) continue; /* a package knew a way round */
      assert_int_equal(status, SCT_E_MEMORY);
      assert_int_equal(err.code, SCT_E_MEMORY);
      assert_true(strlen(err.text) > 10);
      failures++;
    }
    assert_in_range(failures, 100, 5000);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test_setup(flows, packages_fail_too)};
  return cmocka_run_group_tests_name("fault.flow", tests, NULL, NULL);
}
