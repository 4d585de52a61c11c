/* CSV: lines of numbers, with or without a header; every other line is refused by its place. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "doc.h"

static const doc_limits most = {10, 100, 20};

typedef struct {
  const doc *root;
  doc_arena *arena;
  doc_error error;
} decoded;

static decoded decode(const char *text) {
  decoded d;
  const size_t size = strlen(text);
  char *exact = malloc(size > 0 ? size : 1);
  if (size > 0) memcpy(exact, text, size);
  d.root = doc_from_csv(exact, size, &most, &d.arena, &d.error);
  free(exact);
  return d;
}

static void test_read(void **state) {
  (void)state;
  static const struct {
    const char *text;
    int rank;
    int64_t rows, columns;
  } rows[] = {{"1,2\n3,4\n", 2, 2, 2},
              {"1,2\r\n3,4", 2, 2, 2},
              {"x,y\n1,2\n", 2, 1, 2},
              {"# x y\n1,2\n", 2, 1, 2},
              {"\"x\",\"y\"\r\n1,2\r\n", 2, 1, 2},
              {"\xEF\xBB\xBFx\r\n1\r\n2\r\n", 1, 2, 0},
              {"1\n2\n3", 1, 3, 0},
              {" 1 ,\t+2e0 \n-3.5E-1, 4", 2, 2, 2},
              {"nan,inf\n-Inf,NaN", 2, 2, 2},
              {"", 1, 0, 0},
              {"x,y\n", 1, 0, 0}};
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    decoded d = decode(rows[k].text);
    if (d.root == NULL) fail_msg("row %zu: %s", k, d.error.text);
    assert_int_equal(rows[k].rank, d.root->rank);
    assert_int_equal(rows[k].rows, d.root->shape[0]);
    assert_int_equal(rows[k].columns, d.root->shape[1]);
    doc_arena_free(&d.arena);
  }
}

static void test_values(void **state) {
  (void)state;
  decoded d = decode("a,b\n 1 ,\t+2e0 \n-3.5E-1,0.1\nnan,-inf");
  const double *v = d.root->data;
  assert_int_equal(6, d.root->count);
  assert_true(v[0] == 1 && v[1] == 2 && v[2] == -0.35 && v[3] == 0.1);
  assert_true(isnan(v[4]) && v[5] == -HUGE_VAL);
  doc_arena_free(&d.arena);
}

static void test_refused(void **state) {
  (void)state;
  static const struct {
    const char *text, *pointer, *word;
  } rows[] = {{"1,2\n3\n", "/1", "got 1 columns, needs 2"},
              {"1,2\n3,4,5\n", "/1", "got 3 columns, needs 2"},
              {"1,2\n\n3,4\n", "/1", "column 0 is no number"},
              {"1,2\n3,x\n", "/1", "column 1 is no number"},
              {"x,y\nx,y\n", "/0", "column 0 is no number"},
              {"1,2\n3,4 5\n", "/1", "column 1 is no number"},
              {"1,2\n3,0x10\n", "/1", "column 1 is no number"},
              {"1,2\n3,\n", "/1", "column 1 is no number"},
              {"1;2\n3;4\n", "/0", "column 0 is no number"},
              {".5,1\n2,3\n", "/0", "column 0 is no number"},
              {" 1,2,\n3,4\n", "/0", "column 2 is no number"},
              {"-1.,2\n3,4\n", "/0", "column 0 is no number"},
              {"1\n1\n1\n1\n1\n1\n1\n1\n1\n1\n1\n1\n1\n1\n1\n1\n1\n1\n1\n1\n1\n", "/20",
               "more than 20 numbers"}};
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    decoded d = decode(rows[k].text);
    assert_null(d.root);
    assert_string_equal(rows[k].pointer, d.error.pointer);
    if (strstr(d.error.text, rows[k].word) == NULL) fail_msg("row %zu: %s", k, d.error.text);
    assert_int_equal(k == 12, d.error.too_large);
    doc_arena_free(&d.arena);
  }
}

/* Bytes that are no text, a NUL among them. */
static void test_bytes(void **state) {
  (void)state;
  static const char bytes[] = "1,2\n3\0,4\n\xff\xfe,\n";
  doc_arena *arena;
  doc_error error;
  for (size_t size = 0; size < sizeof bytes; size++) {
    char *exact = malloc(size + 1);
    memcpy(exact, bytes, size);
    (void)doc_from_csv(exact, size, &most, &arena, &error);
    doc_arena_free(&arena);
    free(exact);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_read), cmocka_unit_test(test_values),
                                     cmocka_unit_test(test_refused), cmocka_unit_test(test_bytes)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
