/* job_tally.h: against counting by hand. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <stdio.h>

#include "job_tally.h"
#include "seed.h"

enum { NAMES = 7, STEPS = 5000 };

static void test_random(void **state) {
  static const char *const names[NAMES] = {"", "a", "aa", "b", "::1", "local", "alice"};
  int64_t count[NAMES] = {0};
  job_tally t = {0};
  (void)state;
  uint64_t seed = seed_new("job_tally");
  for (int step = 0; step < STEPS; step++) {
    const int k = seed_below(&seed, NAMES), by = seed_below(&seed, 2) > 0 || count[k] == 0 ? 1 : -1;
    assert_true(job_tally_add(&t, names[k], by));
    count[k] += by;
    for (int n = 0; n < NAMES; n++) assert_int_equal(job_tally_of(&t, names[n]), count[n]);
  }
  job_tally_clear(&t);
  assert_int_equal(job_tally_of(&t, "a"), 0);
}

static void test_empty(void **state) {
  job_tally t = {0};
  (void)state;
  assert_int_equal(job_tally_of(&t, "a"), 0);
  assert_true(job_tally_add(&t, "a", 1));
  assert_true(job_tally_add(&t, "a", -1));
  assert_null(t.first); /* who has none takes no room */
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_random), cmocka_unit_test(test_empty)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
