/* JSON decoding: the model, the limits, the errors with place and pointer. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "doc.h"
#include "doc_show.h"

static const doc_limits wide = {.depth = 100, .nodes = 1000000, .numbers = 10000000};

static void check_show(const char *json, const char *expected) {
  doc_arena *arena;
  doc_error error;
  const doc *d = doc_from_json(json, strlen(json), &wide, &arena, &error);
  if (d == NULL) fail_msg("%s: %s", json, error.text);
  char *shown = doc_show(d);
  assert_string_equal(shown, expected);
  free(shown);
  doc_arena_free(&arena);
  assert_null(arena);
}

static void test_model(void **state) {
  static const struct {
    const char *json, *shown;
  } cases[] = {
      {"null", "null"},
      {" true ", "true"},
      {"false", "false"},
      {"-0", "-0"},
      {"1e2", "100"},
      {"\"a\"", "\"a\""},
      {"\"\"", "\"\""},
      {"[]", "<0:>"},
      {"{}", "{}"},
      {"[1]", "<1: 1>"},
      {"[1,2.5,-3]", "<3: 1 2.5 -3>"},
      {"[[1,2],[3,4],[5,6]]", "<3x2: 1 2 3 4 5 6>"},
      {"[[[1],[2]],[[3],[4]]]", "<2x2x1: 1 2 3 4>"},
      {"[[[[1]]]]", "[<1x1x1: 1>]"},
      {"[[[[1]]],[[[2]]]]", "[<1x1x1: 1>, <1x1x1: 2>]"},
      {"[[1,2],[3]]", "[<2: 1 2>, <1: 3>]"},
      {"[[1],[2],[3,4],[5]]", "[<1: 1>, <1: 2>, <2: 3 4>, <1: 5>]"},
      {"[[[1,2],[3,4]],[[5,6]]]", "[<2x2: 1 2 3 4>, <1x2: 5 6>]"},
      {"[[[1,2],[3]],[[4,5]]]", "[[<2: 1 2>, <1: 3>], <1x2: 4 5>]"},
      {"[1,\"a\",2]", "[1, \"a\", 2]"},
      {"[1,2,[3]]", "[1, 2, <1: 3>]"},
      {"[[1],2]", "[<1: 1>, 2]"},
      {"[[],[]]", "[<0:>, <0:>]"},
      {"[[1],[]]", "[<1: 1>, <0:>]"},
      {"[[1,2],[3,null]]", "[<2: 1 2>, [3, null]]"},
      {"[null]", "[null]"},
      {"[{},[1]]", "[{}, <1: 1>]"},
      {"{\"a\":{\"b\":[1,2]},\"c\":3,\"d\":[[4],[5]]}",
       "{\"a\": {\"b\": <2: 1 2>}, \"c\": 3, \"d\": <2x1: 4 5>}"},
      {"[NaN,Infinity,-Infinity,1e999,-1e999]", "<5: nan inf -inf inf -inf>"},
      {"{\"a\":NaN}", "{\"a\": nan}"},
      {"\"\\u0041\\u00e9\\ud83d\\ude00\\n\\/\\\\\\\"\"", "\"A\u00e9\U0001F600\n/\\\"\""},
      {"\"a\\u0000b\\u0000\"", "\"a\\0b\\0\""},
      {"{\"\\u0041\\ud83d\\ude00\":1,\"\":2}", "{\"A\U0001F600\": 1, \"\": 2}"},
      {"\"\u00e9\U0001F600\"", "\"\u00e9\U0001F600\""},
      {"\t[\r\n1 ,\n2 ] ", "<2: 1 2>"},
  };
  (void)state;
  for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
    check_show(cases[k].json, cases[k].shown);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_model),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
