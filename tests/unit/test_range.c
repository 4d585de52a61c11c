/* The field Range: what is a part, what is all of it, what lies outside. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

#include "range.h"

static void test_range(void **state) {
  (void)state;
  static const struct {
    const char *field;
    size_t size;
    range_kind kind;
    size_t first, length;
  } rows[] = {{NULL, 10, RANGE_WHOLE, 0, 0},
              {"bytes=0-0", 10, RANGE_PART, 0, 1},
              {"Bytes=2-5", 10, RANGE_PART, 2, 4},
              {"bytes=2-", 10, RANGE_PART, 2, 8},
              {"bytes=2-99999999999999999999999", 10, RANGE_PART, 2, 8},
              {"bytes=-3", 10, RANGE_PART, 7, 3},
              {"bytes=-30", 10, RANGE_PART, 0, 10},
              {"bytes=9-9", 10, RANGE_PART, 9, 1},
              {"bytes=10-", 10, RANGE_OUTSIDE, 0, 0},
              {"bytes=99999999999999999999999-", 10, RANGE_OUTSIDE, 0, 0},
              {"bytes=-0", 10, RANGE_OUTSIDE, 0, 0},
              {"bytes=0-", 0, RANGE_OUTSIDE, 0, 0},
              {"bytes=-1", 0, RANGE_OUTSIDE, 0, 0},
              {"bytes=5-2", 10, RANGE_WHOLE, 0, 0},
              {"bytes=0-1,3-4", 10, RANGE_WHOLE, 0, 0},
              {"bytes=1", 10, RANGE_WHOLE, 0, 0},
              {"bytes=", 10, RANGE_WHOLE, 0, 0},
              {"bytes=--1", 10, RANGE_WHOLE, 0, 0},
              {"bytes=a-b", 10, RANGE_WHOLE, 0, 0},
              {"lines=0-1", 10, RANGE_WHOLE, 0, 0},
              {"", 10, RANGE_WHOLE, 0, 0}};
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    size_t first = 0, length = 0;
    const range_kind kind = range_of(rows[k].field, rows[k].size, &first, &length);
    if (kind != rows[k].kind) fail_msg("row %zu: got %d", k, kind);
    if (kind != RANGE_PART) continue;
    assert_int_equal(rows[k].first, first);
    assert_int_equal(rows[k].length, length);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_range)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
