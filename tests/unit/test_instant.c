/* instant.h: times and intervals. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <math.h>

#include "instant.h"

static void test_instants(void **state) {
  static const struct {
    const char *text;
    double first, last;
  } good[] = {{"1970-01-01T00:00:00Z", 0, 1},
              {"1970-01-01t00:00:01z", 1, 2},
              {"1970-01-01 00:01:00Z", 60, 61},
              {"2026-11-22T17:50:09Z", 1795369809, 1795369810},
              {"2026-11-22T17:50:09.25Z", 1795369809.25, 1795369809.26},
              {"2026-11-22T18:50:09+01:00", 1795369809, 1795369810},
              {"2026-11-22T12:20:09-05:30", 1795369809, 1795369810},
              {"2024-02-29", 1709164800, 1709251200},
              {"2000-02-29", 951782400, 951868800}};
  (void)state;
  for (size_t k = 0; k < sizeof good / sizeof *good; k++) {
    double first = NAN, last = NAN;
    assert_true(instant_read(good[k].text, (int)strlen(good[k].text), &first, &last));
    assert_true(fabs(first - good[k].first) < 1e-6 && fabs(last - good[k].last) < 1e-6);
  }
}

static void test_no_instants(void **state) {
  static const char *const bad[] = {"",
                                    "yesterday",
                                    "2026",
                                    "2026-1-1",
                                    "2026-13-01",
                                    "2026-01-32",
                                    "2026-02-29",
                                    "2026-02-30T00:00:00Z",
                                    "1900-02-29",
                                    "2026-04-31",
                                    "2026-01-01T00:00:00.Z",
                                    "2026-01-01T",
                                    "2026-01-01T24:00:00Z",
                                    "2026-01-01T00:60:00Z",
                                    "2026-01-01T00:00:00",
                                    "2026-01-01T00:00:00+1:00",
                                    "2026-01-01T00:00:00Zx",
                                    "2026-01-01T00:00:00+01:00 ",
                                    "2026-01-01x",
                                    "..",
                                    "-026-01-01"};
  (void)state;
  for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
    double first, last;
    assert_false(instant_read(bad[k], (int)strlen(bad[k]), &first, &last));
  }
}

static void test_intervals(void **state) {
  double first, last;
  (void)state;
  assert_true(instant_interval("1970-01-01T00:00:05Z/1970-01-02", &first, &last));
  assert_true(first == 5 && last == 172800);
  assert_true(instant_interval("../1970-01-01T00:00:05Z", &first, &last));
  assert_true(first == -INFINITY && last == 6);
  assert_true(instant_interval("1970-01-01T00:00:05Z/", &first, &last));
  assert_true(first == 5 && last == INFINITY);
  assert_true(instant_interval("../..", &first, &last));
  assert_false(instant_interval("/", &first, &last));
  assert_false(instant_interval("1970-01-02/1970-01-01T00:00:00Z", &first, &last));
  assert_false(instant_interval("1970-01-02/x", &first, &last));
  assert_false(instant_interval("a/b/c", &first, &last));
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_instants),
                                     cmocka_unit_test(test_no_instants),
                                     cmocka_unit_test(test_intervals)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
