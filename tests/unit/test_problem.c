/* problem.h: RFC 9457 documents. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "problem.h"

static char *bytes_of(const problem *p) {
  size_t size = 0;
  char *bytes = problem_bytes(p, &size);
  assert_non_null(bytes);
  assert_int_equal(strlen(bytes), size);
  return bytes;
}

static void assert_bytes(const problem *p, const char *expected) {
  char *bytes = bytes_of(p);
  assert_string_equal(bytes, expected);
  free(bytes);
}

static void test_plain(void **state) {
  (void)state;
  problem p;
  problem_begin(&p, 404, "there is no %s", "\"x\"");
  assert_bytes(&p,
               "{\"type\":\"about:blank\",\"title\":\"Not Found\",\"status\":404,"
               "\"detail\":\"there is no \\\"x\\\"\"}");
}

static void test_type(void **state) {
  (void)state;
  problem p;
  problem_begin_type(&p, PROBLEM_NO_SUCH_JOB, 404, "job %d", 7);
  assert_bytes(&p,
               "{\"type\":\"http://www.opengis.net/def/exceptions/ogcapi-processes-1/1.0/"
               "no-such-job\",\"title\":\"No such job\",\"status\":404,\"detail\":\"job 7\"}");
}

static void test_errors(void **state) {
  (void)state;
  problem p;
  problem_begin(&p, 400, "bad");
  problem_add(&p, "/inputs/a~1b", "got %d", 1);
  problem_add(&p, "", "got %s", "none");
  assert_bytes(&p,
               "{\"type\":\"about:blank\",\"title\":\"Bad Request\",\"status\":400,"
               "\"detail\":\"bad\",\"errors\":[{\"pointer\":\"/inputs/a~1b\",\"detail\":\"got 1\"},"
               "{\"pointer\":\"\",\"detail\":\"got none\"}]}");
}

static void test_only_the_first_twenty(void **state) {
  (void)state;
  problem p;
  problem_begin(&p, 400, "bad");
  for (int k = 0; k < 30; k++) problem_add(&p, "/p", "error-%d.", k);
  assert_int_equal(p.count, 20);
  assert_int_equal(p.found, 30);
  char *bytes = bytes_of(&p);
  assert_non_null(strstr(bytes, "error-19."));
  assert_null(strstr(bytes, "error-20."));
  free(bytes);
}

/* A text that a client chose may be anything and of any length. */
static void test_texts_of_clients(void **state) {
  (void)state;
  static const struct {
    const char *text, *kept;
  } rows[] = {{"a\xffz", "a?z"},
              {"\xc3\xa4", "\xc3\xa4"},
              {"\xc0\xaf", "??"},
              {"\xed\xa0\x80", "???"},
              {"\xf0\x9f\x98\x80!", "\xf0\x9f\x98\x80!"},
              {"\xe2\x82", "??"}};
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    problem p;
    problem_begin(&p, 400, "%s", rows[k].text);
    assert_string_equal(p.detail, rows[k].kept);
  }
}

static void test_cuts_between_characters(void **state) {
  (void)state;
  for (size_t shift = 0; shift < 4; shift++) {
    char text[4 * PROBLEM_TEXT] = "aaa";
    problem p;
    for (size_t k = shift; k + 4 < sizeof text; k += 4) memcpy(text + k, "\xf0\x9f\x98\x80", 5);
    problem_begin(&p, 400, "%s", text);
    const size_t length = strlen(p.detail);
    assert_true(length < PROBLEM_TEXT && length + 4 >= PROBLEM_TEXT);
    assert_int_equal(length % 4, shift);
    assert_null(strchr(p.detail, '?'));
    problem_add(&p, text, "%s", text);
    assert_null(strchr(p.errors[0].pointer, '?'));
    assert_null(strchr(p.errors[0].detail, '?'));
  }
}

static void test_shortened_between_words(void **state) {
  static const struct {
    const char *detail, *expected;
  } cases[] = {{"0123456789abcde", "0123456789abcde"},
               {"one two three four", "one two ..."},
               {"0123456789abcdef", "0123456789a ..."},
               {"0123456789\xc3\xa9\xc3\xa9\xc3\xa9", "0123456789 ..."}};
  char room[16];
  problem p;
  (void)state;
  for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
    problem_begin(&p, 400, "%s", cases[k].detail);
    problem_shorten(&p, room, sizeof room);
    assert_string_equal(room, cases[k].expected);
  }
}

static void test_phrases(void **state) {
  (void)state;
  assert_string_equal(problem_phrase(409), "Conflict");
  assert_string_equal(problem_phrase(416), "Range Not Satisfiable");
  assert_string_equal(problem_phrase(422), "Unprocessable Content");
  assert_string_equal(problem_phrase(299), "Error");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_plain),
      cmocka_unit_test(test_type),
      cmocka_unit_test(test_errors),
      cmocka_unit_test(test_only_the_first_twenty),
      cmocka_unit_test(test_texts_of_clients),
      cmocka_unit_test(test_cuts_between_characters),
      cmocka_unit_test(test_shortened_between_words),
      cmocka_unit_test(test_phrases),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
