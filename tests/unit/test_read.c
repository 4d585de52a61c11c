/* Readers: values, defaults, and complaints that point to the culprit. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "read.h"

/* A document and a task that reads it. */
typedef struct {
  task t;
  item root;
} fixture;

static fixture of(const char *json) {
  const doc_limits most = {32, 1000, 1000};
  fixture f = {0};
  doc_error error;
  problem_begin(&f.t.complaints, 400, "test");
  f.root = item_body(doc_from_json(json, strlen(json), &most, &f.t.arena, &error));
  if (!f.root.doc) fail_msg("%s: %s", json, error.text);
  return f;
}

/* The only complaint so far is about `pointer` and says `words`; forgets it. */
static void expect(fixture *f, const char *pointer, const char *words) {
  problem *p = &f->t.complaints;
  assert_int_equal(1, p->found);
  assert_string_equal(pointer, p->errors[0].pointer);
  if (!strstr(p->errors[0].detail, words)) {
    fail_msg("got \"%s\", needs \"%s\"", p->errors[0].detail, words);
  }
  problem_begin(p, 400, "test");
}

static void expect_well(fixture *f) {
  assert_true(task_is_well(&f->t));
  doc_arena_free(&f->t.arena);
}

static void test_number(void **state) {
  static const range part = {0, 1, false, true};
  fixture f = of("{\"a\": 0.5, \"b\": 1, \"c\": \"x\", \"d\": NaN, \"e\": Infinity}");
  item a = item_member(&f.root, "a"), b = item_member(&f.root, "b"), c = item_member(&f.root, "c");
  item d = item_member(&f.root, "d"), e = item_member(&f.root, "e");
  item none = item_member(&f.root, "none");
  double value = 7;
  (void)state;
  assert_true(read_number(&f.t, &none, &part, &value));
  assert_true(value == 7);
  assert_true(read_number(&f.t, &a, &part, &value));
  assert_true(value == 0.5);
  assert_false(read_number(&f.t, &b, &part, &value));
  expect(&f, "/b", "is 1, needs a number from 0 and below 1");
  assert_false(read_number(&f.t, &c, &range_positive, &value));
  expect(&f, "/c", "is \"x\", needs a number above 0");
  assert_false(read_number(&f.t, &d, &range_any, &value));
  expect(&f, "/d", "needs a finite number");
  assert_false(read_number(&f.t, &e, &range_any, &value));
  expect(&f, "/e", "needs a finite number");
  assert_true(value == 0.5);
  assert_false(read_required(&f.t, &none));
  expect(&f, "/none", "is missing");
  expect_well(&f);
}

static void test_integer(void **state) {
  fixture f = of("{\"a\": 3, \"b\": 3.5, \"c\": 1e300, \"d\": true}");
  item a = item_member(&f.root, "a"), b = item_member(&f.root, "b"), c = item_member(&f.root, "c");
  item d = item_member(&f.root, "d");
  int64_t value = 0;
  bool truth = false;
  (void)state;
  assert_true(read_integer(&f.t, &a, 3, 4, &value));
  assert_int_equal(3, value);
  assert_false(read_integer(&f.t, &a, 4, 5, &value));
  expect(&f, "/a", "is 3, needs an integer from 4 to 5");
  assert_false(read_integer(&f.t, &b, 0, 9, &value));
  expect(&f, "/b", "is 3.5");
  assert_false(read_integer(&f.t, &c, 0, INT64_MAX, &value));
  expect(&f, "/c", "is 1e+300");
  assert_true(read_boolean(&f.t, &d, &truth));
  assert_true(truth);
  assert_false(read_boolean(&f.t, &a, &truth));
  expect(&f, "/a", "needs true or false");
  expect_well(&f);
}

static void test_text(void **state) {
  static const char *const names[] = {"one", "two", "three", NULL};
  fixture f = of("{\"a\": \"two\", \"b\": \"twoo\", \"c\": \"a\\u0000b\", \"d\": [1]}");
  item a = item_member(&f.root, "a"), b = item_member(&f.root, "b"), c = item_member(&f.root, "c");
  item d = item_member(&f.root, "d");
  const char *text = NULL;
  int choice = 9;
  (void)state;
  assert_true(read_text(&f.t, &a, &text));
  assert_string_equal("two", text);
  assert_true(read_choice(&f.t, &a, names, &choice));
  assert_int_equal(1, choice);
  assert_false(read_choice(&f.t, &b, names, &choice));
  expect(&f, "/b", "is \"twoo\", needs one, two or three");
  assert_false(read_text(&f.t, &c, &text));
  expect(&f, "/c", "NUL");
  assert_false(read_text(&f.t, &d, &text));
  expect(&f, "/d", "is an array of 1 number");
  expect_well(&f);
}

static void test_object(void **state) {
  static const char *const members[] = {"radius", "kernel", NULL};
  fixture f =
      of("{\"a\": {\"radius\": 1}, \"b\": {\"raduis\": 1}, \"c\": {\"zzz\": 1}, \"d\": []}");
  item a = item_member(&f.root, "a"), b = item_member(&f.root, "b"), c = item_member(&f.root, "c");
  item d = item_member(&f.root, "d");
  (void)state;
  assert_true(read_object(&f.t, &a, members));
  assert_false(read_object(&f.t, &b, members));
  expect(&f, "/b/raduis", "did you mean \"radius\"?");
  assert_false(read_object(&f.t, &c, members));
  expect(&f, "/c/zzz", "needs one of radius or kernel");
  assert_false(read_object(&f.t, &d, members));
  expect(&f, "/d", "needs an object");
  expect_well(&f);
}

static void test_numbers(void **state) {
  fixture f =
      of("{\"a\": [1, 2, 3], \"b\": [[1, 2], [3, 4], [5, NaN]], \"c\": [1, \"x\"],"
         " \"d\": [[1, 2], [3]], \"e\": [], \"f\": 1, \"g\": [1, 2.5], \"h\": [[1], [\"q\"]]}");
  item a = item_member(&f.root, "a"), b = item_member(&f.root, "b"), c = item_member(&f.root, "c");
  item d = item_member(&f.root, "d"), e = item_member(&f.root, "e"), n = item_member(&f.root, "f");
  item g = item_member(&f.root, "g"), h = item_member(&f.root, "h");
  numbers value = {0};
  (void)state;
  assert_true(read_numbers(&f.t, &a, 1, &value));
  assert_int_equal(3, value.rows);
  assert_int_equal(1, value.columns);
  assert_true(value.data[2] == 3);
  assert_false(read_numbers(&f.t, &a, 2, &value));
  expect(&f, "/a", "is an array of 3 numbers, needs an array of arrays");
  assert_false(read_numbers(&f.t, &b, 2, &value));
  expect(&f, "/b/2/1", "is nan");
  assert_false(read_numbers(&f.t, &c, 1, &value));
  expect(&f, "/c/1", "needs a number");
  assert_false(read_numbers(&f.t, &d, 2, &value));
  expect(&f, "/d/1", "needs an array of 2 numbers");
  assert_true(read_numbers(&f.t, &e, 2, &value));
  assert_int_equal(0, value.rows);
  assert_false(read_numbers(&f.t, &n, 1, &value));
  expect(&f, "/f", "is 1, needs an array of numbers");
  assert_false(read_integers(&f.t, &g, 0, 9, &value));
  expect(&f, "/g/1", "is 2.5, needs an integer from 0 to 9");
  assert_false(read_numbers(&f.t, &h, 2, &value));
  expect(&f, "/h/1/0", "is \"q\"");
  assert_int_equal(1, item_rank(&a));
  assert_int_equal(2, item_rank(&b));
  assert_int_equal(2, item_rank(&d));
  assert_int_equal(0, item_rank(&n));
  expect_well(&f);
}

static void test_input(void **state) {
  fixture f =
      of("{\"bare\": {\"points\": 1}, \"qualified\": {\"value\": {\"points\": 1}},"
         " \"typed\": {\"value\": 3, \"mediaType\": \"x/y\"}, \"own\": {\"value\": 1, \"on\": 2},"
         " \"parameters\": {\"value\": 4}}");
  item bare = item_input(&f.root, "bare"), qualified = item_input(&f.root, "qualified");
  item typed = item_input(&f.root, "typed"), own = item_input(&f.root, "own");
  item parameters = item_input(&f.root, "parameters");
  item points = item_member(&qualified, "points");
  char pointer[PROBLEM_POINTER];
  (void)state;
  assert_false(bare.wrapped);
  assert_non_null(doc_member(bare.doc, "points"));
  assert_non_null(points.doc);
  item_pointer(&points, pointer);
  assert_string_equal("/qualified/value/points", pointer);
  assert_true(typed.doc->number == 3);
  assert_int_equal(DOC_OBJECT, own.doc->kind);
  assert_int_equal(DOC_OBJECT, parameters.doc->kind);
  expect_well(&f);
}

/* Escapes, and names that do not fit. */
static void test_pointer(void **state) {
  char pointer[PROBLEM_POINTER], name[400];
  doc nothing = {.kind = DOC_NULL};
  item root = item_body(&nothing), a = {.up = &root, .key = "a/b~c"};
  item b = item_element(&a, NULL, 12), c = {.up = &b, .key = name}, d = item_element(&c, NULL, 1);
  (void)state;
  memset(name, 'n', sizeof name - 1);
  name[sizeof name - 1] = '\0';
  item_pointer(&root, pointer);
  assert_string_equal("", pointer);
  item_pointer(&b, pointer);
  assert_string_equal("/a~1b~0c/12", pointer);
  item_pointer(&d, pointer);
  assert_string_equal("/a~1b~0c/12", pointer);
}

static void test_words(void **state) {
  static const char *const names[] = {"diffusivity", "velocity", "source", NULL};
  char room[SHOWN_MAX];
  (void)state;
  assert_string_equal("diffusivity", nearest_name("difusivity", names));
  assert_string_equal("source", nearest_name("sources", names));
  assert_null(nearest_name("kernel", names));
  assert_null(nearest_name("", names));
  assert_string_equal("short", shown("short", room));
  /* 39 bytes and a character of two: it must not be torn apart */
  assert_string_equal("aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa...",
                      shown("aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa\xc3\xa4zzzzzzzzzz", room));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_number),  cmocka_unit_test(test_integer), cmocka_unit_test(test_text),
      cmocka_unit_test(test_object),  cmocka_unit_test(test_numbers), cmocka_unit_test(test_input),
      cmocka_unit_test(test_pointer), cmocka_unit_test(test_words),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
