/* Content codings: there and back, foreign streams, limits, damage. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <zstd.h>

#include <cmocka.h>

#include "inflate.h"
#include "seed.h"

enum { TEXT = 300000 };

/* Half of it compressible. */
static char *any_text(uint64_t *r) {
  char *text = malloc(TEXT);
  for (int k = 0; k < TEXT; k++) {
    text[k] = (char)(k % 1000 < 500 ? 'a' + k % 7 : seed_below(r, 256));
  }
  return text;
}

static void check_back(coding c, const char *text, size_t size) {
  void *packed, *back;
  size_t packed_size, back_size;
  assert_int_equal(deflate_bytes(c, text, size, &packed, &packed_size), INFLATE_OK);
  assert_int_equal(inflate_bytes(c, packed, packed_size, size, &back, &back_size), INFLATE_OK);
  assert_int_equal(back_size, size);
  assert_memory_equal(back, text, size);
  free(back);
  /* One byte less is one too few. */
  if (size > 0) {
    assert_int_equal(inflate_bytes(c, packed, packed_size, size - 1, &back, &back_size),
                     INFLATE_TOO_LARGE);
    assert_null(back);
  }
  free(packed);
}

static void test_back(void **state) {
  uint64_t r = seed_new("unit.inflate");
  char *text = any_text(&r);
  (void)state;
  for (int c = 0; c < CODING_COUNT; c++) {
    static const size_t sizes[] = {0, 1, 100, 16383, 16384, 16385, 65536, TEXT};
    for (size_t k = 0; k < sizeof sizes / sizeof sizes[0]; k++) {
      check_back((coding)c, text, sizes[k]);
    }
  }
  free(text);
}

/* Deflating makes small what repeats. */
static void test_smaller(void **state) {
  char *text = calloc(TEXT, 1);
  (void)state;
  for (int c = CODING_GZIP; c < CODING_COUNT; c++) {
    void *packed;
    size_t size;
    assert_int_equal(deflate_bytes((coding)c, text, TEXT, &packed, &size), INFLATE_OK);
    assert_true(size < TEXT / 100);
    free(packed);
  }
  free(text);
}

/* Two members or frames one after the other are one body. */
static void test_members(void **state) {
  (void)state;
  for (int c = CODING_GZIP; c < CODING_COUNT; c++) {
    void *one, *two, *back;
    size_t size, back_size;
    deflate_bytes((coding)c, "abc", 3, &one, &size);
    two = malloc(2 * size);
    memcpy(two, one, size);
    memcpy((char *)two + size, one, size);
    assert_int_equal(inflate_bytes((coding)c, two, 2 * size, 6, &back, &back_size), INFLATE_OK);
    assert_int_equal(back_size, 6);
    assert_memory_equal(back, "abcabc", 6);
    free(back);
    assert_int_equal(inflate_bytes((coding)c, two, 2 * size, 5, &back, &back_size),
                     INFLATE_TOO_LARGE);
    free(one);
    free(two);
  }
}

/* What is cut short, goes on behind its end, or is of another kind. */
static void test_damaged(void **state) {
  (void)state;
  for (int c = CODING_GZIP; c < CODING_COUNT; c++) {
    void *packed, *back;
    size_t size, back_size;
    deflate_bytes((coding)c, "some text, some text, some text", 31, &packed, &size);
    for (size_t n = 0; n < size; n++) {
      assert_int_equal(inflate_bytes((coding)c, packed, n, 100, &back, &back_size), INFLATE_BAD);
      assert_null(back);
    }
    unsigned char *longer = calloc(1, size + 20);
    memcpy(longer, packed, size);
    assert_int_equal(inflate_bytes((coding)c, longer, size + 20, 100, &back, &back_size),
                     INFLATE_BAD);
    int other = c == CODING_GZIP ? CODING_ZSTD : CODING_GZIP;
    assert_int_equal(inflate_bytes((coding)other, packed, size, 100, &back, &back_size),
                     INFLATE_BAD);
    free(longer);
    free(packed);
  }
}

/* A wrong check sum is found. */
static void test_check_sum(void **state) {
  void *packed, *back;
  size_t size, back_size;
  (void)state;
  deflate_bytes(CODING_GZIP, "some text", 9, &packed, &size);
  ((unsigned char *)packed)[size - 6] ^= 1;
  assert_int_equal(inflate_bytes(CODING_GZIP, packed, size, 100, &back, &back_size), INFLATE_BAD);
  free(packed);
}

/* A bomb: a megabyte for a gigabyte stops at the limit, and so does one that claims its size. */
static void test_bomb(void **state) {
  enum { ZEROS = 64 << 20, LIMIT = 1 << 20 };
  char *zeros = calloc(ZEROS, 1);
  (void)state;
  for (int c = CODING_GZIP; c < CODING_COUNT; c++) {
    void *packed, *back;
    size_t size, back_size;
    assert_int_equal(deflate_bytes((coding)c, zeros, ZEROS, &packed, &size), INFLATE_OK);
    assert_true(size < ZEROS / 100);
    assert_int_equal(inflate_bytes((coding)c, packed, size, LIMIT, &back, &back_size),
                     INFLATE_TOO_LARGE);
    assert_int_equal(inflate_bytes((coding)c, packed, size, ZEROS, &back, &back_size), INFLATE_OK);
    assert_int_equal(back_size, ZEROS);
    free(back);
    free(packed);
  }
  free(zeros);
}

/* A frame that asks for a window of 512 MiB gets none (RFC 9659 allows 8 MiB). */
static void test_window(void **state) {
  static const unsigned char huge[] = {0x28, 0xB5, 0x2F, 0xFD, 0x00, 0x98, 0x01, 0x00, 0x00};
  void *back;
  size_t back_size;
  (void)state;
  assert_int_equal(inflate_bytes(CODING_ZSTD, huge, sizeof huge, 1000, &back, &back_size),
                   INFLATE_TOO_LARGE);
}

/* A frame of an 8 MiB window made by the library itself, and a gzip stream of another level. */
static void test_foreign(void **state) {
  enum { SIZE = 9 << 20 };
  uint64_t r = seed_new("unit.inflate");
  char *text = malloc(SIZE), *packed = malloc(SIZE + SIZE / 8);
  void *back;
  size_t back_size;
  (void)state;
  for (int k = 0; k < SIZE; k++) text[k] = (char)seed_below(&r, 4);
  ZSTD_CCtx *z = ZSTD_createCCtx();
  ZSTD_CCtx_setParameter(z, ZSTD_c_windowLog, 23);
  ZSTD_CCtx_setParameter(z, ZSTD_c_contentSizeFlag, 0);
  size_t size = ZSTD_compress2(z, packed, SIZE + SIZE / 8, text, SIZE);
  ZSTD_freeCCtx(z);
  assert_int_equal(inflate_bytes(CODING_ZSTD, packed, size, SIZE, &back, &back_size), INFLATE_OK);
  assert_int_equal(back_size, SIZE);
  assert_memory_equal(back, text, SIZE);
  free(back);
  free(text);
  free(packed);
}

static void test_messages(void **state) {
  (void)state;
  for (int s = INFLATE_BAD; s <= INFLATE_MEMORY; s++) {
    assert_non_null(strstr(inflate_text((inflate_status)s), "body"));
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_back),      cmocka_unit_test(test_smaller),
      cmocka_unit_test(test_members),   cmocka_unit_test(test_damaged),
      cmocka_unit_test(test_check_sum), cmocka_unit_test(test_bomb),
      cmocka_unit_test(test_window),    cmocka_unit_test(test_foreign),
      cmocka_unit_test(test_messages),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
