/* job_state.h: names and transitions. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "job_state.h"

static void test_names(void **state) {
  static const char *const names[] = {"accepted", "running", "successful", "failed", "dismissed"};
  (void)state;
  for (int k = 0; k < JOB_STATES; k++) {
    assert_string_equal(job_state_name((job_state)k), names[k]);
    assert_int_equal(job_state_of(names[k], (int)strlen(names[k])), k);
    assert_int_equal(job_state_of(names[k], (int)strlen(names[k]) - 1), -1);
  }
  assert_int_equal(job_state_of("", 0), -1);
}

/* Every pair: a row for each state, a column for each next one. */
static void test_transitions(void **state) {
  static const bool may[JOB_STATES][JOB_STATES] = {{false, true, true, true, true},
                                                   {true, false, true, true, true},
                                                   {false, false, false, false, true},
                                                   {false, false, false, false, true},
                                                   {false, false, false, false, false}};
  (void)state;
  for (int from = 0; from < JOB_STATES; from++) {
    for (int to = 0; to < JOB_STATES; to++) {
      assert_int_equal(job_state_may((job_state)from, (job_state)to), may[from][to]);
    }
    assert_int_equal(job_state_is_final((job_state)from), from >= JOB_SUCCESSFUL);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_names),
                                     cmocka_unit_test(test_transitions)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
