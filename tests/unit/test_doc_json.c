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

/* ---- numbers: strtod is the oracle ---- */

static void check_number(const char *text) {
  double expected = strtod(text, NULL);
  char json[4096];
  const doc *d;
  doc_arena *arena;
  doc_error error;
  snprintf(json, sizeof json, "{\"alone\":%s,\"array\":[1,%s]}", text, text);
  d = doc_from_json(json, strlen(json), &wide, &arena, &error);
  assert_non_null(d);
  assert_memory_equal(&doc_member(d, "alone")->number, &expected, sizeof expected);
  assert_memory_equal(&doc_member(d, "array")->data[1], &expected, sizeof expected);
  doc_arena_free(&arena);
}

static void test_numbers(void **state) {
  static const char *const texts[] = {
      "0",
      "-0",
      "-0.0e5",
      "0.1",
      "9007199254740993",
      "9007199254740991",
      "-9223372036854775809",
      "123456789012345678901234567890",
      "2.2250738585072011e-308",
      "2.2250738585072014e-308",
      "4.9406564584124654e-324",
      "2.4703282292062327e-324",
      "2.4703282292062328e-324",
      "1.7976931348623157e308",
      "1.7976931348623158e308",
      "1.7976931348623159e308",
      "1e308",
      "1e309",
      "-1e309",
      "1e-400",
      "-1e-400",
      "0e999999999999999999999",
      "1e999999999999999999999",
      "1e-999999999999999999999",
      "0.0000000000000000000000000000000000000001e345",
      "0.0000000000000000000000000000000000000001e351",
      "10000000000000000000000000000000000000000e-360",
      "10000000000000000000000000000000000000000e-380",
      "7.2057594037927933e16",
      "6.631236846766476e-316",
      "8.5e-00000000000000000000001",
  };
  (void)state;
  for (size_t k = 0; k < sizeof texts / sizeof texts[0]; k++) check_number(texts[k]);
}

/* Halves between neighbours, with more digits than any buffer on the way may hold. */
static void test_long_numbers(void **state) {
  (void)state;
  char text[1200] = "1.";
  for (int k = 0; k < 1000; k++) strcat(text, k % 10 == 9 ? "7" : "0");
  check_number(text);
  snprintf(text, sizeof text, "9007199254740993.%0900d", 0);
  check_number(text);
  snprintf(text, sizeof text, "9007199254740993.%0900d1", 0);
  check_number(text);
  snprintf(text, sizeof text, "0.%0400d1e400", 0);
  check_number(text);
  snprintf(text, sizeof text, "0.%0700d1e400", 0);
  check_number(text);
  snprintf(text, sizeof text, "1%0700de-400", 0);
  check_number(text);
}

/* ---- grammar ---- */

/* %HH becomes the byte. */
static size_t unescape(char *text) {
  char *to = text;
  for (const char *p = text; *p != '\0'; p++) {
    unsigned byte;
    if (*p == '%' && sscanf(p + 1, "%2x", &byte) == 1) {
      *to++ = (char)byte;
      p += 2;
    } else {
      *to++ = *p;
    }
  }
  return (size_t)(to - text);
}

static void check_case(char *line) {
  char verdict[16], python[16];
  int start = 0;
  doc_arena *arena;
  doc_error error;
  assert_int_equal(sscanf(line, "%15[a-z] %15[a-z]%n", verdict, python, &start), 2);
  char *document = line + start + 1, shown[256];
  snprintf(shown, sizeof shown, "%s", document);
  /* Exactly sized, so that a sanitizer sees any step beyond the end. */
  size_t size = unescape(document);
  char *body = malloc(size + (size == 0));
  memcpy(body, document, size);
  bool accepted = doc_from_json(body, size, &wide, &arena, &error) != NULL;
  free(body);
  doc_arena_free(&arena);
  if (accepted != (strcmp(verdict, "accept") == 0)) {
    fail_msg("%s: expected %s; %s", shown, verdict, accepted ? "accepted" : error.text);
  }
}

static void test_cases(void **state) {
  char line[512];
  int count = 0;
  FILE *cases = fopen(JSON_CASES, "r");
  (void)state;
  assert_non_null(cases);
  while (fgets(line, sizeof line, cases) != NULL) {
    line[strcspn(line, "\n")] = '\0';
    if (line[0] == '#') continue;
    check_case(line);
    count++;
  }
  fclose(cases);
  assert_true(count > 100);
}

/* No proper start of a document in brackets is a document. */
static void test_truncated(void **state) {
  static const char json[] =
      "{\"a\":[1,2.5e-3,[true,\"\\ud83d\\ude00\u00e9\"]],\"b\":{\"c\":null,\"d\":[[1,2],[3,4]]}}";
  (void)state;
  for (size_t n = 0; n < sizeof json - 1; n++) {
    char *body = malloc(n + 1);
    doc_arena *arena;
    doc_error error;
    memcpy(body, json, n);
    body = realloc(body, n + (n == 0));
    assert_null(doc_from_json(body, n, &wide, &arena, &error));
    assert_true(error.offset <= (int64_t)n);
    doc_arena_free(&arena);
    free(body);
  }
}

/* ---- errors ---- */

static void test_errors(void **state) {
  static const struct {
    const char *json;
    int64_t offset;
    const char *pointer, *text;
  } cases[] = {
      {"", 0, "", "line 1, column 1: got the end of the body, needed a value"},
      {"{\"x\":[1,2,{\"k\":[1,tru]}]}", 18, "/x/2/k/1",
       "line 1, column 19: got 't', needed a value"},
      {"[1,\n 2,\n  x]", 10, "/2", "line 3, column 3: got 'x', needed a value"},
      {"[1 2]", 3, "", "line 1, column 4: got '2', needed ',' or ']'"},
      {"{\"a\":[[1,2],[3 4]]}", 15, "/a/1", "line 1, column 16: got '4', needed ',' or ']'"},
      {"{\"a\":1 2}", 7, "", "line 1, column 8: got '2', needed ',' or '}'"},
      {"{\"a\":1,}", 7, "", "line 1, column 8: got '}', needed a key in '\"'"},
      {"{\"a\"1}", 4, "/a", "line 1, column 5: got '1', needed ':'"},
      {"[1] x", 4, "", "line 1, column 5: got 'x', needed the end of the body"},
      {"[\"\u00e9\u00e9\", 01]", 9, "/1",
       "line 1, column 8: got a number that is not as JSON writes it"},
      {"[\"a\nb\"]", 3, "/0", "line 1, column 4: got byte 0x0A in a string, needed an escape"},
      {"[\"\xFF\"]", 2, "/0", "line 1, column 3: got byte 0xFF, needed UTF-8"},
      {"[\"\\q\"]", 2, "/0", "line 1, column 3: got an unknown escape or half a surrogate pair"},
      {"\xEF\xBB\xBF[]", 0, "", "line 1, column 1: got a byte order mark, needed a value"},
      {"[\x01]", 1, "/0", "line 1, column 2: got byte 0x01, needed a value"},
      {"{\"a\":1,\"a\":2}", 7, "/a", "line 1, column 8: key \"a\" is there twice in an object"},
      {"[{\"z\":1,\"b/~\":{\"c\":1,\"d\":2,\"\\u0063\":3}}]", 27, "/0/b~1~0/c",
       "line 1, column 28: key \"c\" is there twice in an object"},
      {"{\"a\":1,\"b\":2,\"b\":3,\"a\":4}", 13, "/b",
       "line 1, column 14: key \"b\" is there twice in an object"},
      {"{\"k\\u0000\":1}", 1, "/k", "line 1, column 2: a key contains a NUL character"},
  };
  (void)state;
  for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
    doc_arena *arena;
    doc_error error;
    assert_null(doc_from_json(cases[k].json, strlen(cases[k].json), &wide, &arena, &error));
    assert_string_equal(error.text, cases[k].text);
    assert_string_equal(error.pointer, cases[k].pointer);
    assert_int_equal(error.offset, cases[k].offset);
    assert_false(error.too_large);
    doc_arena_free(&arena);
  }
}

/* A pointer that does not fit names the innermost container that does. */
static void test_long_pointer(void **state) {
  char json[1000] = "{\"short\":{\"";
  doc_arena *arena;
  doc_error error;
  (void)state;
  for (int k = 0; k < 300; k++) strcat(json, "/");
  strcat(json, "\":x}}");
  assert_null(doc_from_json(json, strlen(json), &wide, &arena, &error));
  assert_string_equal(error.pointer, "/short");
  doc_arena_free(&arena);
}

/* The same, step by step: every length of the pointer is met, and nothing behind it is touched. */
static void test_pointer_room(void **state) {
  static const char *const keys[] = {"{\"\":", "{\"a\":", "{\"~\":", "[0,"};
  (void)state;
  for (size_t k = 0; k < sizeof keys / sizeof keys[0]; k++) {
    for (int depth = 1; depth < 300; depth++) {
      char json[5 * 300 + 2] = "";
      doc_limits limits = {400, 1000, 1000};
      doc_arena *arena;
      doc_error error;
      for (int d = 0; d < depth; d++) strcat(json, keys[k]);
      strcat(json, "x");
      assert_null(doc_from_json(json, strlen(json), &limits, &arena, &error));
      assert_non_null(strstr(error.text, "got 'x'"));
      assert_true(memchr(error.pointer, 0, sizeof error.pointer) != NULL);
      doc_arena_free(&arena);
    }
  }
}

/* ---- limits ---- */

/* Decodes under limits; *too_large tells a limit from a fault. */
static bool takes(const char *json, size_t size, doc_limits limits, doc_error *error) {
  doc_arena *arena;
  bool taken = doc_from_json(json, size, &limits, &arena, error) != NULL;
  doc_arena_free(&arena);
  assert_true(taken || error->too_large);
  return taken;
}

static void check_limit(const char *json, doc_limits enough, doc_limits less, const char *pointer) {
  doc_error error;
  assert_true(takes(json, strlen(json), enough, &error));
  assert_false(takes(json, strlen(json), less, &error));
  assert_string_equal(error.pointer, pointer);
}

static void test_limits(void **state) {
  (void)state;
  check_limit("[[[1]]]", (doc_limits){3, 1, 1}, (doc_limits){2, 1, 1}, "/0/0");
  check_limit("{\"a\":{\"b\":0}}", (doc_limits){2, 3, 1}, (doc_limits){1, 3, 1}, "/a");
  check_limit("7", (doc_limits){0, 1, 1}, (doc_limits){0, 0, 1}, "");
  check_limit("[1,2,3]", (doc_limits){1, 1, 3}, (doc_limits){1, 1, 2}, "/2");
  check_limit("[[1,2],[3,4]]", (doc_limits){2, 1, 4}, (doc_limits){2, 1, 3}, "/1/1");
  check_limit("[1,2,\"a\"]", (doc_limits){1, 4, 2}, (doc_limits){1, 3, 2}, "/2");
  check_limit("[1,2,{}]", (doc_limits){2, 4, 2}, (doc_limits){2, 2, 2}, "/2");
  check_limit("[[1],[2],[]]", (doc_limits){2, 4, 2}, (doc_limits){2, 3, 2}, "/2");
  check_limit("{\"a\":1,\"b\":[1,2]}", (doc_limits){2, 3, 3}, (doc_limits){2, 2, 3}, "/b");
  check_limit("{\"a\":1,\"b\":[1,2]}", (doc_limits){2, 3, 3}, (doc_limits){2, 3, 2}, "/b/1");
}

static char *repeat(const char *what, size_t times, const char *last) {
  size_t n = strlen(what);
  char *text = malloc(n * times + strlen(last) + 1);
  for (size_t k = 0; k < times; k++) memcpy(text + n * k, what, n);
  strcpy(text + n * times, last);
  return text;
}

static void test_depth(void **state) {
  doc_limits limits = {1 << 20, 1 << 20, 10};
  doc_error error;
  (void)state;
  char *open = repeat("[", 1000000, ""), *objects = repeat("{\"a\":", 300000, "");
  assert_false(takes(open, strlen(open), limits, &error));
  assert_int_equal(error.offset, DOC_DEPTH_MAX + 1);
  assert_false(takes(objects, strlen(objects), limits, &error));
  memset(open + DOC_DEPTH_MAX, ']', DOC_DEPTH_MAX);
  assert_true(takes(open, 2 * DOC_DEPTH_MAX, limits, &error));
  free(open);
  free(objects);
}

/* Bodies on which a careless decoder is quadratic, or keeps far more than they hold. They finish at
 * once or not within the time of a test. */
static void test_hostile(void **state) {
  doc_limits limits = {100, 5000000, 5000000};
  doc_error error;
  static const struct {
    const char *first, *each, *last;
    size_t times;
  } cases[] = {
      {"[", "1,", "null]", 1000000},
      {"[", "[1],", "null]", 500000},
      {"[", "[[[1]]],", "null]", 300000},
      {"[", "[],", "[]]", 300000},
      {"[[", "1,2,", "\"\"],1]", 500000},
      {"[", "[1,2],", "[3]]", 300000},
      {"\"", "\\u0000", "\"", 300000},
      {"\"", "\\n", "\"", 1000000},
      {"[[[[[[[[", "1,", "{}]]]]]]]]", 1000000},
  };
  (void)state;
  for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
    char *middle = repeat(cases[k].each, cases[k].times, cases[k].last);
    char *json = malloc(strlen(middle) + strlen(cases[k].first) + 1);
    strcat(strcpy(json, cases[k].first), middle);
    assert_true(takes(json, strlen(json), limits, &error));
    free(middle);
    free(json);
  }
}

static void test_many_keys(void **state) {
  enum { KEYS = 300000 };
  doc_limits limits = {4, 2 * KEYS, 2 * KEYS};
  char *json = malloc(KEYS * 24 + 32), *to = json;
  doc_arena *arena;
  doc_error error;
  (void)state;
  *to++ = '{';
  for (int k = 0; k < KEYS; k++) to += sprintf(to, "\"k%d\":%d,", k, k);
  char *last = to;
  to += sprintf(to, "\"z\":1}");
  assert_true(takes(json, (size_t)(to - json), limits, &error));
  to = last + sprintf(last, "\"k77\":1}");
  assert_null(doc_from_json(json, (size_t)(to - json), &limits, &arena, &error));
  assert_string_equal(error.pointer, "/k77");
  assert_int_equal(error.offset, last - json);
  doc_arena_free(&arena);
  free(json);
}

/* ---- reading a document ---- */

static void test_navigation(void **state) {
  static const char json[] =
      "{\"o\":{\"a\":1},\"l\":[\"x\",true,null],\"n\":[1,2],\"e\":[],\"m\":[[1,2,3]],\"s\":[5],"
      "\"i\":NaN}";
  static const struct {
    const char *key, *described;
  } cases[] = {
      {"o", "an object of 1 member"},
      {"l", "a list of 3 values"},
      {"n", "an array of 2 numbers"},
      {"e", "an empty array"},
      {"m", "an array of 1 x 3 numbers"},
      {"s", "an array of 1 number"},
      {"i", "NaN"},
  };
  char room[64];
  doc_arena *arena;
  doc_error error;
  (void)state;
  const doc *d = doc_from_json(json, strlen(json), &wide, &arena, &error);
  for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
    const doc *member = doc_member(d, cases[k].key);
    assert_string_equal(doc_describe(member, room, sizeof room), cases[k].described);
  }
  const doc *list = doc_member(d, "l");
  assert_string_equal(doc_describe(doc_at(list, 0), room, sizeof room), "a string");
  assert_string_equal(doc_describe(doc_at(list, 1), room, sizeof room), "true");
  assert_string_equal(doc_describe(doc_at(list, 2), room, sizeof room), "null");
  assert_null(doc_at(list, 3));
  assert_null(doc_at(list, -1));
  assert_null(doc_at(d, 0));
  assert_null(doc_at(NULL, 0));
  assert_null(doc_member(d, "x"));
  assert_null(doc_member(list, "x"));
  assert_null(doc_member(NULL, "x"));
  doc_arena_free(&arena);
}

static void test_arena(void **state) {
  (void)state;
  doc_arena *arena = doc_arena_new();
  for (size_t n = 0; n < 3000; n += 7) {
    char *memory = doc_arena_take(arena, n);
    assert_int_equal((uintptr_t)memory % 16, 0);
    memset(memory, 0xAA, n);
  }
  memset(doc_arena_take(arena, 5000000), 0, 5000000);
  assert_null(doc_arena_take(arena, SIZE_MAX));
  assert_null(doc_arena_take(arena, SIZE_MAX / 2));
  doc_arena_free(&arena);
  doc_arena_free(&arena);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_model),        cmocka_unit_test(test_numbers),
      cmocka_unit_test(test_long_numbers), cmocka_unit_test(test_cases),
      cmocka_unit_test(test_truncated),    cmocka_unit_test(test_errors),
      cmocka_unit_test(test_long_pointer), cmocka_unit_test(test_pointer_room),
      cmocka_unit_test(test_limits),       cmocka_unit_test(test_depth),
      cmocka_unit_test(test_hostile),      cmocka_unit_test(test_many_keys),
      cmocka_unit_test(test_navigation),   cmocka_unit_test(test_arena),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
