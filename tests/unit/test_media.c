/* media.h and field.h: what a client sent, what it takes. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "field.h"
#include "media.h"

static span text_of(const char *text) {
  return (span){text, strlen(text)};
}

static void test_list(void **state) {
  (void)state;
  const char *rest = " a ; x=1;q=0.5,, b=\"c,\\\"d;e\" ;y=\"z\",  ,c";
  field_item item;
  span value;
  assert_true(field_next(&rest, &item));
  assert_true(span_is(item.name, "A"));
  assert_int_equal(item.value.length, 0);
  assert_true(field_parameter(&item, "X", &value) && span_is(value, "1"));
  assert_true(field_quality(&item) == 0.5);
  assert_true(field_next(&rest, &item));
  assert_true(span_is(item.name, "b") && span_is(item.value, "c,\\\"d;e"));
  assert_true(field_parameter(&item, "y", &value) && span_is(value, "z"));
  assert_false(field_parameter(&item, "x", &value));
  assert_true(field_quality(&item) == 1);
  assert_true(field_next(&rest, &item));
  assert_true(span_is(item.name, "c"));
  assert_false(field_next(&rest, &item));
  assert_false(field_next(&rest, &item));
}

static void test_broken_lists_end(void **state) {
  (void)state;
  static const char *const texts[] = {"",     ",",      ";", ";;,;",  "\"", "a=\"b",
                                      "a;\"", "a=\"\\", "=", "a;=;q", "\\", ",,,\",,,"};
  for (size_t k = 0; k < sizeof texts / sizeof *texts; k++) {
    field_item item;
    int items = 0;
    for (const char *rest = texts[k]; field_next(&rest, &item); items++) {
      const double q = field_quality(&item);
      assert_true(q >= 0 && q <= 1);
    }
    assert_true(items <= 2);
  }
}

static void test_quality_values(void **state) {
  (void)state;
  static const struct {
    const char *text;
    double value;
  } rows[] = {{"0", 0}, {"1", 1},         {"0.25", 0.25}, {"1.000", 1}, {".5", 0.5},
              {"2", 1}, {"-1", 0},        {"x", 0},       {"1e1", 0},   {"0.1.1", 0},
              {"", 0},  {"\"0.5\"", 0.5}, {"0,5", 0}};
  for (size_t k = 0; k + 1 < sizeof rows / sizeof *rows; k++) {
    char text[32] = "a; q=";
    field_item item = {.name = text_of("a")};
    strcat(text, rows[k].text);
    const char *rest = text;
    assert_true(field_next(&rest, &item));
    assert_true(field_quality(&item) == rows[k].value);
  }
}

static void test_choose(void **state) {
  (void)state;
  static const char *const offers[] = {"application/json", "application/cbor", "text/html"};
  static const struct {
    const char *accept;
    int chosen;
  } rows[] = {
      {NULL, 0},
      {"", 0},
      {" , ", 0},
      {"*/*", 0},
      {"application/cbor", 1},
      {"APPLICATION/CBOR", 1},
      {"application/*", 0},
      {"text/*", 2},
      {"image/png", -1},
      {"image/png, */*;q=0.1", 0},
      {"application/json;q=0.5, application/cbor", 1},
      {"application/json;q=0.5, application/cbor;q=0.5", 0},
      {"*/*, application/json;q=0", 1}, /* the more specific range counts */
      {"application/*;q=0.3, application/json;q=0.1, text/html;q=0.2", 1},
      {"application/json;q=0", -1},
      {"text/html;level=1, application/json;q=0.9", 2},
      {"application", -1},
      {"application/jsonx", -1},
      {"nonsense;;;q=,", -1},
  };
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    assert_int_equal(media_choose(rows[k].accept, offers, 3), rows[k].chosen);
  }
  const char *const api[] = {"application/vnd.oai.openapi+json;version=3.0"};
  assert_int_equal(media_choose("application/vnd.oai.openapi+json", api, 1), 0);
  assert_int_equal(media_choose("application/vnd.oai.openapi+json;version=3.0;q=0.1", api, 1), 0);
}

static void test_names(void **state) {
  (void)state;
  assert_true(media_names("text/html, application/json;q=0.1", "application/json"));
  assert_false(media_names("application/*, */*", "application/json"));
  assert_false(media_names("application/json;q=0", "application/json"));
  assert_false(media_names(NULL, "application/json"));
}

static void test_body_type(void **state) {
  (void)state;
  static const struct {
    const char *text;
    int type; /* -1: refused */
  } rows[] = {{NULL, MEDIA_JSON},
              {"application/json", MEDIA_JSON},
              {" Application/JSON ; charset=UTF-8", MEDIA_JSON},
              {"application/json;charset=\"utf-8\"", MEDIA_JSON},
              {"application/json;profile=x", MEDIA_JSON},
              {"application/cbor", MEDIA_CBOR},
              {"application/json;charset=latin1", -1},
              {"application/json, application/json", -1},
              {"application/problem+json", -1},
              {"text/plain", -1},
              {"", -1}};
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    media got;
    assert_int_equal(media_of_body(rows[k].text, &got), rows[k].type >= 0);
    if (rows[k].type >= 0) assert_int_equal(got, rows[k].type);
  }
}

static void test_body_coding(void **state) {
  (void)state;
  static const struct {
    const char *text;
    int coding; /* -1: refused */
  } rows[] = {{NULL, CODING_IDENTITY},
              {"", CODING_IDENTITY},
              {"identity", CODING_IDENTITY},
              {"GZip", CODING_GZIP},
              {"x-gzip", CODING_GZIP},
              {"zstd", CODING_ZSTD},
              {"br", -1},
              {"identity, gzip", CODING_GZIP},
              {"gzip, gzip", -1},
              {"gzip, zstd", -1},
              {"deflate", -1}};
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    coding got;
    assert_int_equal(coding_of_body(rows[k].text, &got), rows[k].coding >= 0);
    if (rows[k].coding >= 0) assert_int_equal(got, rows[k].coding);
  }
}

static void test_reply_coding(void **state) {
  (void)state;
  static const struct {
    const char *text;
    int coding; /* -1: none fits */
  } rows[] = {{NULL, CODING_IDENTITY},
              {"", CODING_IDENTITY},
              {"gzip", CODING_GZIP},
              {"gzip, deflate, br", CODING_GZIP},
              {"gzip, deflate, br, zstd", CODING_ZSTD},
              {"gzip, zstd;q=0.5", CODING_GZIP},
              {"*", CODING_IDENTITY},
              {"br", CODING_IDENTITY},
              {"gzip;q=0", CODING_IDENTITY},
              {"identity, gzip;q=0.5", CODING_IDENTITY},
              {"identity;q=0, gzip", CODING_GZIP},
              {"*;q=0, zstd", CODING_ZSTD},
              {"identity;q=0", -1},
              {"*;q=0", -1},
              {"br, *;q=0", -1}};
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    coding got;
    assert_int_equal(coding_choose(rows[k].text, &got), rows[k].coding >= 0);
    if (rows[k].coding >= 0) assert_int_equal(got, rows[k].coding);
  }
}

static void test_coding_taken(void **state) {
  (void)state;
  assert_true(coding_accepts("gzip, deflate, br, zstd", CODING_GZIP));
  assert_true(coding_accepts("br, x-gzip;q=0.1", CODING_GZIP));
  assert_false(coding_accepts("zstd, gzip;q=0", CODING_GZIP));
  assert_false(coding_accepts("*", CODING_GZIP));
  assert_false(coding_accepts("br", CODING_GZIP));
  assert_false(coding_accepts(NULL, CODING_GZIP));
}

static void test_tables(void **state) {
  (void)state;
  assert_string_equal(media_type(MEDIA_PROBLEM), "application/problem+json");
  assert_string_equal(coding_name(CODING_ZSTD), "zstd");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_list),           cmocka_unit_test(test_broken_lists_end),
      cmocka_unit_test(test_quality_values), cmocka_unit_test(test_choose),
      cmocka_unit_test(test_names),          cmocka_unit_test(test_body_type),
      cmocka_unit_test(test_body_coding),    cmocka_unit_test(test_reply_coding),
      cmocka_unit_test(test_coding_taken),   cmocka_unit_test(test_tables),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
