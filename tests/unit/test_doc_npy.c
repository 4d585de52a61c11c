/* .npy files: what numpy writes is read; what it would not write is refused, never read beyond its
 * end (the body is copied to its exact size, so ASan sees it). */
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "doc.h"

static const doc_limits most = {10, 100, 1000};

/* A file of version `version` around a header (padded by blanks if `padding`) and bytes. */
static unsigned char *file_of(int version, const char *header, const void *data, size_t bytes,
                              size_t *size) {
  const size_t lead = version == 1 ? 10 : 12, length = strlen(header);
  unsigned char *file = malloc(lead + length + bytes + 1);
  memcpy(file, "\x93NUMPY", 6);
  file[6] = (unsigned char)version;
  file[7] = 0;
  file[8] = (unsigned char)length;
  file[9] = (unsigned char)(length >> 8);
  if (version > 1) file[10] = file[11] = 0;
  memcpy(file + lead, header, length);
  if (bytes > 0) memcpy(file + lead + length, data, bytes);
  *size = lead + length + bytes;
  return file;
}

typedef struct {
  const doc *root;
  doc_arena *arena;
  doc_error error;
} decoded;

static decoded decode(const void *bytes, size_t size) {
  decoded d;
  void *exact = malloc(size > 0 ? size : 1);
  if (size > 0) memcpy(exact, bytes, size);
  d.root = doc_from_npy(exact, size, &most, &d.arena, &d.error);
  free(exact);
  return d;
}

static decoded decode_file(const char *header, const void *data, size_t bytes) {
  size_t size;
  unsigned char *file = file_of(1, header, data, bytes, &size);
  decoded d = decode(file, size);
  free(file);
  return d;
}

#define HEAD(type, shape) "{'descr': '" type "', 'fortran_order': False, 'shape': " shape ", }\n"

static void test_types(void **state) {
  (void)state;
  static const unsigned char f8[] = {0, 0, 0, 0, 0, 0, 0xf8, 0xbf}, f4[] = {0xbf, 0xc0, 0, 0};
  static const unsigned char i2[] = {0xfe, 0xff}, u4[] = {0xff, 0xff, 0xff, 0xff}, one[] = {1};
  static const unsigned char i8[] = {0, 0, 0, 0, 0, 0, 1, 0}, i1[] = {0x80}, f2[] = {0, 0x3e};
  const struct {
    const char *header;
    const void *data;
    size_t bytes;
    double value;
  } rows[] = {{HEAD("<f8", "(1,)"), f8, 8, -1.5},
              {HEAD(">f4", "(1,)"), f4, 4, -1.5},
              {HEAD("<i2", "(1,)"), i2, 2, -2},
              {HEAD(">i2", "(1,)"), i2, 2, -257},
              {HEAD("<u4", "(1,)"), u4, 4, 4294967295.0},
              {HEAD(">i8", "(1,)"), i8, 8, 256},
              {HEAD("|b1", "(1,)"), one, 1, 1},
              {HEAD("|u1", "(1,)"), i1, 1, 128},
              {HEAD("|i1", "(1,)"), i1, 1, -128},
              {HEAD("<f2", "(1,)"), f2, 2, 1.5},
              {HEAD("<i8", "(1,)"), i8, 8, 281474976710656.0}};
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    decoded d = decode_file(rows[k].header, rows[k].data, rows[k].bytes);
    if (d.root == NULL) fail_msg("%s: %s", rows[k].header, d.error.text);
    assert_int_equal(DOC_NUMBERS, d.root->kind);
    assert_int_equal(1, d.root->count);
    if (d.root->data[0] != rows[k].value) fail_msg("%s: %g", rows[k].header, d.root->data[0]);
    doc_arena_free(&d.arena);
  }
}

static void test_shapes(void **state) {
  (void)state;
  const double data[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11};
  decoded d = decode_file(HEAD("<f8", "(2, 3)"), data, 48);
  assert_int_equal(2, d.root->rank);
  assert_int_equal(3, d.root->shape[1]);
  assert_true(d.root->data[3] == 3);
  doc_arena_free(&d.arena);
  d = decode_file("{'descr': '<f8', 'fortran_order': True, 'shape': (2, 3), }", data, 48);
  assert_true(d.root->data[1] == 2 && d.root->data[2] == 4 && d.root->data[3] == 1);
  doc_arena_free(&d.arena);
  d = decode_file("{'descr': '<f8', 'fortran_order': True, 'shape': (2, 3, 2), }", data, 96);
  assert_true(d.root->data[1] == 6 && d.root->data[2] == 2 && d.root->data[11] == 11);
  doc_arena_free(&d.arena);
  d = decode_file(HEAD("<f8", "()"), data + 5, 8);
  assert_int_equal(DOC_NUMBER, d.root->kind);
  assert_true(d.root->number == 5);
  doc_arena_free(&d.arena);
  d = decode_file(HEAD("<f8", "(0, 3)"), NULL, 0);
  assert_int_equal(DOC_NUMBERS, d.root->kind);
  assert_int_equal(0, d.root->count);
  doc_arena_free(&d.arena);
}

/* Any order of entries, quotes of both kinds, blanks anywhere, no comma at the end; versions. */
static void test_headers(void **state) {
  (void)state;
  const double data[] = {4, 5};
  static const char *const headers[] = {
      "{\"shape\":(2,),'fortran_order':False,'descr':'<f8'}",
      " { 'shape' : ( 2 , ) , \"descr\" : \"<f8\" , 'fortran_order' : False , }  \n",
      "{'shape':(2L,),'fortran_order':True,'descr':'=f8'}"};
  for (int version = 1; version <= 3; version++) {
    for (size_t k = 0; k < sizeof headers / sizeof *headers; k++) {
      size_t size;
      unsigned char *file = file_of(version, headers[k], data, sizeof data, &size);
      decoded d = decode(file, size);
      if (d.root == NULL) fail_msg("%s: %s", headers[k], d.error.text);
      assert_true(d.root->count == 2 && d.root->data[1] == 5);
      doc_arena_free(&d.arena);
      free(file);
    }
  }
}

static void test_refused(void **state) {
  (void)state;
  static const struct {
    const char *header;
    size_t bytes;
    const char *word; /* in the message */
  } rows[] = {
      {HEAD("<f8", "(2,)"), 15, "needs 16 bytes, got 15"},
      {HEAD("<f8", "(2,)"), 17, "needs 16 bytes, got 17"},
      {HEAD("<f8", "(9223372036854775807,)"), 8, "too large"},
      {HEAD("<f8", "(4294967296, 4294967296)"), 8, "more numbers than fit"},
      {HEAD("<f8", "(99999999999999999999999,)"), 8, "too large"},
      {HEAD("<f8", "(1001,)"), 8008, "at most 1000"},
      {HEAD("<f8", "(1, 1, 1, 1)"), 8, "more than 3 ranks"},
      {HEAD("<f8", "(-1,)"), 8, "integer"},
      {HEAD("<f8", "2"), 16, "needs ("},
      {HEAD("<f8", "(2"), 16, "integer"},
      {HEAD("|O", "(2,)"), 16, "type |O"},
      {HEAD("<U5", "(2,)"), 40, "type <U5"},
      {HEAD("<c8", "(2,)"), 16, "type <c8"},
      {HEAD("<f16", "(1,)"), 16, "type <f16"},
      {HEAD("<i3", "(1,)"), 3, "type <i3"},
      {HEAD("<f1", "(1,)"), 1, "type <f1"},
      {HEAD("<b8", "(1,)"), 8, "type <b8"},
      {HEAD("", "(1,)"), 8, "type"},
      {HEAD("a string that is far too long to be a type", "(1,)"), 8, "too long"},
      {"{'descr': [('x', '<f8')], 'fortran_order': False, 'shape': (1,)}", 8, "structured"},
      {"{'descr': '<f8', 'fortran_order': Maybe, 'shape': (1,)}", 8, "True or False"},
      {"{'descr': '<f8', 'fortran_order': False}", 8, "needs descr, fortran_order and shape"},
      {"{'descr': '<f8', 'order': False, 'shape': (1,)}", 8, "unknown entry"},
      {"{'descr': '<f8'", 8, "needs }"},
      {"{'descr", 8, "needs '"},
      {"", 8, "needs {"},
      {HEAD("<f8", "(1,)") "x", 8, "follows the header"},
  };
  static const char zeros[8008];
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    decoded d = decode_file(rows[k].header, zeros, rows[k].bytes);
    assert_null(d.root);
    if (strstr(d.error.text, rows[k].word) == NULL) {
      fail_msg("%s: got \"%s\", needs \"%s\"", rows[k].header, d.error.text, rows[k].word);
    }
    doc_arena_free(&d.arena);
  }
}

/* Cut anywhere, and each byte of the file changed: refused or read, never worse. */
static void test_damaged(void **state) {
  (void)state;
  const double data[] = {1, 2};
  size_t size;
  unsigned char *file = file_of(1, HEAD("<f8", "(2,)"), data, sizeof data, &size);
  for (size_t cut = 0; cut < size; cut++) {
    decoded d = decode(file, cut);
    assert_null(d.root);
    doc_arena_free(&d.arena);
  }
  for (size_t at = 0; at < size; at++) {
    for (int bit = 0; bit < 8; bit++) {
      file[at] ^= (unsigned char)(1 << bit);
      decoded d = decode(file, size);
      doc_arena_free(&d.arena);
      file[at] ^= (unsigned char)(1 << bit);
    }
  }
  file[6] = 4;
  decoded d = decode(file, size);
  assert_non_null(strstr(d.error.text, "version 4.0"));
  doc_arena_free(&d.arena);
  free(file);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_types),   cmocka_unit_test(test_shapes),
      cmocka_unit_test(test_headers), cmocka_unit_test(test_refused),
      cmocka_unit_test(test_damaged),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
