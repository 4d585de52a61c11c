/* unit.doc_make: documents made in memory, pointers into them and means of them. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "doc_make.h"

static const doc_limits MOST = {32, 1000, 1000};

static const doc *decoded(const char *text, doc_arena **arena) {
  doc_error error;
  const doc *d = doc_from_json(text, strlen(text), &MOST, arena, &error);
  assert_non_null(d);
  return d;
}

static void test_making(void **state) {
  const double values[] = {1, 2, 3};
  task t = {.arena = doc_arena_new()};
  doc *object = doc_make_object(&t, NULL);
  (void)state;
  assert_true(doc_append(object, doc_make_number(&t, "a", 4)));
  assert_true(doc_append(object, doc_make_numbers(&t, "b", values, 3)));
  assert_true(doc_append(object, doc_make_alias(&t, "c", doc_member(object, "b"))));
  assert_false(doc_append(object, NULL));
  assert_int_equal(object->count, 3);
  assert_true(doc_member(object, "a")->number == 4);
  assert_ptr_equal(doc_member(object, "c")->data, doc_member(object, "b")->data);
  assert_null(doc_member(object, "c")->next);
  doc_arena_free(&t.arena);
}

static void test_pointers(void **state) {
  doc_arena *arena;
  const doc *d = decoded("{\"a\":{\"b\":[[1],{\"c\":7},\"x\"],\"d\":[4,5]}}", &arena);
  (void)state;
  assert_ptr_equal(doc_at_pointer(d, ""), d);
  assert_true(doc_at_pointer(d, "/a/b/1/c")->number == 7);
  assert_string_equal(doc_at_pointer(d, "/a/b/2")->text, "x");
  assert_null(doc_at_pointer(d, "/a/b/3"));
  assert_null(doc_at_pointer(d, "/a/x/c"));
  assert_true(doc_number_at(d, "/a/b/1/c") == 7);
  assert_true(doc_number_at(d, "/a/d/1") == 5);
  assert_true(isnan(doc_number_at(d, "/a/d/2")));
  assert_true(isnan(doc_number_at(d, "/a/d")));
  assert_true(isnan(doc_number_at(d, "/nothing/0")));
  doc_arena_free(&arena);
}

static void test_means(void **state) {
  doc_arena *first, *second;
  task t = {.arena = doc_arena_new()};
  const doc *a =
      decoded("{\"n\":1,\"v\":[0.1,2],\"o\":{\"m\":3,\"s\":\"text\"},\"w\":[1]}", &first);
  const doc *b = decoded("{\"n\":2,\"v\":[0.1,4],\"o\":{\"m\":5},\"w\":[1,2]}", &second);
  (void)state;
  doc *mean = doc_mean_begin(&t, a);
  for (int64_t k = 2; k <= 10; k++) doc_mean(mean, k % 2 ? a : b, k);
  doc_arena_free(&first);
  doc_arena_free(&second);
  assert_true(fabs(doc_number_at(mean, "/n") - 1.5) < 1e-15);
  assert_true(doc_number_at(mean, "/v/0") == 0.1); /* of equal numbers, that number */
  assert_true(fabs(doc_number_at(mean, "/v/1") - 3) < 1e-15);
  assert_true(fabs(doc_number_at(mean, "/o/m") - 4) < 1e-15);
  assert_true(doc_number_at(mean, "/w/0") == 1); /* another shape does not count */
  assert_null(doc_at_pointer(mean, "/o/s"));
  doc_arena_free(&t.arena);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_making), cmocka_unit_test(test_pointers),
                                     cmocka_unit_test(test_means)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
