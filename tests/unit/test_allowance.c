/* allowance.h: never more than the quota, and counted seldom. */
#include <errno.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "allowance.h"

typedef struct {
  int64_t bytes;
  int counts;
} truth;

static int64_t count(void *self, const char *owner) {
  truth *t = self;
  assert_string_equal(owner, "me");
  t->counts++;
  return t->bytes;
}

static void test_all(void **state) {
  truth t = {.bytes = 60};
  const allowance_counter counter = {count, &t, "me"};
  allowance a = {0};
  (void)state;
  assert_true(allowance_take(&a, 30, 100, 10, &counter)); /* counts what was there before */
  assert_int_equal(t.counts, 1);
  assert_true(allowance_take(&a, 10, 100, 10, &counter));
  assert_false(allowance_take(&a, 1, 100, 10.5, &counter));
  assert_int_equal(t.counts, 1); /* not so soon */
  t.bytes = 100;
  assert_false(allowance_take(&a, 1, 100, 12, &counter));
  assert_int_equal(t.counts, 2);
  t.bytes = 50; /* something went */
  assert_true(allowance_take(&a, 50, 100, 14, &counter));
  assert_int_equal(t.counts, 3);
  assert_true(allowance_take(&a, 0, 100, 14, &counter));
  assert_false(allowance_take(&a, 1, 100, 14, &counter));
}

static void test_nothing_at_all(void **state) {
  truth t = {0};
  const allowance_counter counter = {count, &t, "me"};
  allowance a = {0};
  (void)state;
  assert_true(allowance_take(&a, 0, 0, 5, &counter));
  assert_false(allowance_take(&a, 1, 0, 5, &counter));
}

/* Unknown, or full as far as one knows. */
static void test_why(void **state) {
  truth t = {.bytes = -1};
  const allowance_counter counter = {count, &t, "me"};
  allowance a = {0};
  (void)state;
  assert_false(allowance_take(&a, 0, 100, 10, &counter));
  assert_int_equal(errno, EHOSTDOWN);
  t.bytes = 60;
  assert_false(allowance_take(&a, 50, 100, 10, &counter));
  assert_int_equal(errno, EDQUOT);
  t.bytes = -1;
  assert_false(allowance_take(&a, 50, 100, 12, &counter));
  assert_int_equal(errno, EDQUOT);
  assert_true(allowance_take(&a, 40, 100, 12, &counter));
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_all),
                                     cmocka_unit_test(test_nothing_at_all),
                                     cmocka_unit_test(test_why)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
