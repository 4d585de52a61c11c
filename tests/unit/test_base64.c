/* base64: the vectors of RFC 4648, both ways, and what is none. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base64.h"

static void test_vectors(void **state) {
  (void)state;
  static const char *const rows[][2] = {{"", ""},
                                        {"f", "Zg=="},
                                        {"fo", "Zm8="},
                                        {"foo", "Zm9v"},
                                        {"foob", "Zm9vYg=="},
                                        {"fooba", "Zm9vYmE="},
                                        {"foobar", "Zm9vYmFy"},
                                        {"\xff\xfe\xfb", "//77"}};
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    size_t length;
    long long size;
    char *text = base64_encode(rows[k][0], strlen(rows[k][0]), &length);
    assert_string_equal(rows[k][1], text);
    assert_int_equal(strlen(text), length);
    unsigned char *back = base64_decode(text, length, &size);
    assert_int_equal(strlen(rows[k][0]), size);
    assert_memory_equal(rows[k][0], back, (size_t)size);
    free(text);
    free(back);
  }
}

static void test_tolerated(void **state) {
  (void)state;
  static const char *const rows[][2] = {
      {"Zm8", "fo"}, {" Zm\r\n8= ", "fo"}, {"__77", "\xff\xfe\xfb"}};
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    long long size;
    unsigned char *back = base64_decode(rows[k][0], strlen(rows[k][0]), &size);
    assert_int_equal(strlen(rows[k][1]), size);
    assert_memory_equal(rows[k][1], back, (size_t)size);
    free(back);
  }
}

static void test_refused(void **state) {
  (void)state;
  static const char *const rows[] = {
      "Z", "Zm9vY", "Zm8*", "Z=g=", "Zg=", "Zg===", "Zm9v=", "Zm\x80v"};
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    long long size;
    unsigned char *back = base64_decode(rows[k], strlen(rows[k]), &size);
    if (size != -1) fail_msg("%s was taken", rows[k]);
    free(back);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_vectors),
                                     cmocka_unit_test(test_tolerated),
                                     cmocka_unit_test(test_refused)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
