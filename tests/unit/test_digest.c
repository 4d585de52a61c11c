/* digest.h: the published test vectors (FIPS 180-4; RFC 4231). */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <errno.h>
#include <stdio.h>
#include <sys/mman.h>
#include <unistd.h>

#include "digest.h"

static int file_of(const char *text) {
  const int fd = memfd_create("text", 0);
  assert_int_equal(write(fd, text, strlen(text)), strlen(text));
  return fd;
}

static void test_sha256(void **state) {
  char text[DIGEST_TEXT], labelled[DIGEST_TEXT];
  const int fd = file_of("abc");
  (void)state;
  assert_true(digest_file(NULL, -1, 0, text));
  assert_string_equal(text, "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  assert_true(digest_file(NULL, fd, 3, text));
  assert_string_equal(text, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  assert_false(digest_file(NULL, fd, 4, text));
  assert_int_equal(errno, EIO);
  assert_true(digest_file("ab", fd, 0, text));
  close(fd);
  const int rest = file_of("b");
  assert_true(digest_file("a", rest, 1, labelled)); /* the label ends where it ends */
  assert_string_not_equal(text, labelled);
  close(rest);
}

static void test_hmac(void **state) {
  static const char expected[] = "5bdcc146bf60754e6a042426089575c75a003f089d2739839dec58b964ec3843";
  unsigned char sum[DIGEST_BYTES];
  (void)state;
  digest_sign("Jefe", "what do ya want ", "for nothing?", 12, sum);
  for (int k = 0; k < DIGEST_BYTES; k++) {
    char two[3];
    snprintf(two, sizeof two, "%02x", sum[k]);
    assert_memory_equal(two, expected + 2 * k, 2);
  }
}

static void test_memory(void **state) {
  static const unsigned char expected[] = {0xba, 0x78, 0x16, 0xbf};
  unsigned char sum[DIGEST_BYTES], other[DIGEST_BYTES];
  (void)state;
  digest_bytes("abc", 3, sum);
  assert_memory_equal(sum, expected, sizeof expected);
  memcpy(other, sum, sizeof other);
  assert_true(digest_is(sum, other));
  for (int k = 0; k < 8 * DIGEST_BYTES; k++) {
    other[k / 8] ^= (unsigned char)(1 << k % 8);
    assert_false(digest_is(sum, other));
    other[k / 8] ^= (unsigned char)(1 << k % 8);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_sha256), cmocka_unit_test(test_hmac),
                                     cmocka_unit_test(test_memory)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
