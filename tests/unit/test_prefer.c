/* prefer.h: the Prefer field. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "prefer.h"

static void test_prefer(void **state) {
  (void)state;
  static const struct {
    const char *text;
    bool respond_async;
    double wait;
  } rows[] = {{NULL, false, -1},
              {"", false, -1},
              {"respond-async", true, -1},
              {"Respond-Async, Wait=10", true, 10},
              {"wait=5;x=\"a,b\", return=minimal", false, 5},
              {"foo; respond-async", false, -1},
              {"foo=\"respond-async, wait=3\"", false, -1},
              {"wait=1, wait=2", false, 1},
              {"wait=x, wait=2", false, 2},
              {"wait", false, -1},
              {"wait=-1", false, -1},
              {"wait=1.5", false, -1},
              {"wait=\"7\" ; q", false, 7},
              {"wait=100", false, 100},
              {"wait=99999999999999999999", false, 100},
              {"handling=lenient,respond-async;a=b", true, -1}};
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    const prefer got = prefer_of(rows[k].text, 100);
    assert_int_equal(got.respond_async, rows[k].respond_async);
    assert_true(got.wait == rows[k].wait);
  }
}

static void test_shape_and_priority(void **state) {
  static const struct {
    const char *text;
    prefer_shape shape;
    int priority;
  } rows[] = {{"", PREFER_ANY, -1},
              {"return=minimal", PREFER_MINIMAL, -1},
              {"return=\"representation\", return=minimal", PREFER_REPRESENTATION, -1},
              {"return=other, priority=0", PREFER_ANY, 0},
              {"priority=9; x, priority=1", PREFER_ANY, 9},
              {"priority=10, priority=-1, priority, priority=x", PREFER_ANY, -1}};
  (void)state;
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    const prefer got = prefer_of(rows[k].text, 100);
    assert_int_equal(got.shape, rows[k].shape);
    assert_int_equal(got.priority, rows[k].priority);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_prefer),
      cmocka_unit_test(test_shape_and_priority),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
