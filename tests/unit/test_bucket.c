/* bucket.h: how many at once, how many in the long run. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <math.h>

#include "bucket.h"

static void test_burst_then_rate(void **state) {
  bucket b = {0};
  (void)state;
  for (int k = 0; k < 5; k++) assert_true(bucket_take(&b, 2, 5, 1000) == 0);
  assert_true(fabs(bucket_take(&b, 2, 5, 1000) - 0.5) < 1e-9);
  assert_true(fabs(bucket_take(&b, 2, 5, 1000.25) - 0.25) < 1e-9);
  assert_true(bucket_take(&b, 2, 5, 1000.5) == 0);
  assert_true(bucket_take(&b, 2, 5, 1000.5) > 0);
}

/* However requests come, no window of time holds more than burst + rate * window. */
static void test_long_run(void **state) {
  static const double rate = 3, burst = 4, step = 0.01;
  bucket b = {0};
  int taken = 0;
  (void)state;
  for (int k = 0; k < 100000; k++) taken += bucket_take(&b, rate, burst, 50 + k * step) == 0;
  assert_true(taken <= burst + rate * 1000);
  assert_true(taken >= rate * 1000);
}

static void test_never_fuller_than_full(void **state) {
  bucket b = {0};
  (void)state;
  assert_true(bucket_take(&b, 1, 2, 0) == 0);
  for (int k = 0; k < 2; k++) assert_true(bucket_take(&b, 1, 2, 1e9) == 0);
  assert_true(bucket_take(&b, 1, 2, 1e9) > 0);
}

static void test_a_clock_that_goes_back(void **state) {
  bucket b = {0};
  (void)state;
  assert_true(bucket_take(&b, 1, 1, 100) == 0);
  assert_true(bucket_take(&b, 1, 1, 50) > 0);
  assert_true(bucket_take(&b, 1, 1, 51) == 0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_burst_then_rate), cmocka_unit_test(test_long_run),
      cmocka_unit_test(test_never_fuller_than_full), cmocka_unit_test(test_a_clock_that_goes_back)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
