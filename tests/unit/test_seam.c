/* seam.h: headers as libmicrohttpd leaves them, whole and with something hidden. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "seam.h"

/* '|' is the NUL that libmicrohttpd puts in place of a colon or the end of a line. */
static bool is_broken(bool strict, const char *text, const int at[], int fields) {
  char header[200];
  seam s = {.is_strict = strict};
  const size_t size = strlen(text);
  memcpy(header, text, size + 1);
  for (size_t k = 0; k < size; k++) {
    if (header[k] == '|') header[k] = '\0';
  }
  for (int k = 0; k < 2 * fields; k += 2) seam_field(&s, header + at[k], header + at[k + 1]);
  seam_end(&s, header + size);
  return s.is_broken;
}

#define WHERE(...) ((const int[]){__VA_ARGS__})

static void test_whole(void **state) {
  (void)state;
  assert_false(is_broken(true, "", NULL, 0));
  assert_false(is_broken(true, "Host| a||||", WHERE(0, 6), 1));
  assert_false(is_broken(true, "Host| a||B|c||||", WHERE(0, 6, 9, 11), 2));
  assert_false(is_broken(true, "Host| a|B| \tc||", WHERE(0, 6, 8, 12), 2)); /* LF only */
  assert_false(is_broken(true, "Host|||B|  ||||", WHERE(0, 5, 7, 11), 2));  /* empty values */
}

static void test_names(void **state) {
  (void)state;
  for (int strict = 0; strict <= 1; strict++) {
    assert_true(is_broken(strict, "Transfer-Encoding | a||||", WHERE(0, 20), 1));
    assert_true(is_broken(strict, "A\tB| a||||", WHERE(0, 5), 1));
    assert_true(is_broken(strict, "| a||||", WHERE(0, 2), 1));
    assert_true(is_broken(strict, "A\x80| a||||", WHERE(0, 4), 1));
  }
}

static void test_hidden(void **state) {
  (void)state;
  /* Content-Length:<CRLF> 47, which became the name "Content-Length47" */
  assert_true(is_broken(true, "Content-Length47|||||", WHERE(0, 15), 1));
  /* X: y<CRLF> z where the name was moved away */
  assert_true(is_broken(true, "y||   z||||Xz|", WHERE(11, 0), 1));
  /* X:  y<CRLF> z, so that name and value still fit together: the line is missing */
  assert_true(is_broken(true, "Xz|y|| z||||", WHERE(0, 3), 1));
  assert_true(is_broken(true, "Xz|y|| z||A|b||||", WHERE(0, 3, 10, 12), 2));
  /* a line without a name, which ended it */
  assert_true(is_broken(true, "A|b||| x||", WHERE(0, 2), 1));
  /* a NUL in a value */
  assert_true(is_broken(true, "A|b|c||D|e||||", WHERE(0, 2, 7, 9), 2));
  /* a library that reads them right may have them anywhere */
  assert_false(is_broken(false, "A|b   ||c|d||||||", WHERE(0, 2, 8, 10), 2));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_whole),
      cmocka_unit_test(test_names),
      cmocka_unit_test(test_hidden),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
