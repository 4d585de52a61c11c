/* Decoders, encoders and content codings with the n-th allocation failing, for every n: nothing
 * comes out, the error says memory, nothing leaks (with -DSCATTERD_SANITIZE=ON). */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "doc.h"
#include "emit.h"
#include "inflate.h"
#include "scarce.h"

static const doc_limits wide = {.depth = 20, .nodes = 10000, .numbers = 100000};

static const char json[] =
    "{\"a\":[[1,2],[3,4],[5]],\"\\u0062\":\"text\\u0000\",\"c\":{\"d\":[true,null,\"x\",[],7]},"
    "\"e\":[1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16,17,18,19,20],\"f\":[[1],[\"y\"]],\"g\":0,"
    "\"h\":1,\"i\":2,\"j\":3,\"k\":4,\"l\":5,\"m\":6,\"n\":7,\"o\":8,\"p\":9,\"q\":10,\"r\":11}";

/* Text in chunks, numbers by columns, a packed array, a list. */
static const unsigned char cbor[] = {0xA4, 0x61, 'a',  0x7F, 0x62, 'x',  'y',  0x61, 'z',  0xFF,
                                     0x61, 'b',  0xD9, 0x04, 0x10, 0x82, 0x82, 0x02, 0x02, 0x84,
                                     0x01, 0x02, 0x03, 0x04, 0x61, 'c',  0xD8, 0x40, 0x43, 0x01,
                                     0x02, 0x03, 0x61, 'd',  0x83, 0x01, 0xF6, 0x81, 0xF5};

/* Runs once; true if it worked. */
typedef bool attempt(void);

/* Every allocation fails once, alone or with all that follow; the run that misses none works. */
static void fail_each(attempt *run) {
  for (int lasting = 0; lasting <= 1; lasting++) {
    int64_t granted = 0;
    bool worked, failed;
    do {
      scarce_after(granted++, lasting);
      worked = run();
      failed = scarce_end();
      if (worked == failed) fail_msg("allocation %d failed, and nobody noticed", (int)granted);
    } while (failed);
    assert_true(granted > 2);
  }
}

/* Without memory there is no document, and the error says why. */
static bool check(const doc *d, doc_arena **arena, const doc_error *error) {
  doc_arena_free(arena);
  assert_true(d != NULL || (error->too_large && strstr(error->text, "memory") != NULL));
  return d != NULL;
}

static bool decode_json(void) {
  doc_arena *arena;
  doc_error error;
  const doc *d = doc_from_json(json, sizeof json - 1, &wide, &arena, &error);
  return check(d, &arena, &error);
}

static bool decode_cbor(void) {
  doc_arena *arena;
  doc_error error;
  const doc *d = doc_from_cbor(cbor, sizeof cbor, &wide, &arena, &error);
  return check(d, &arena, &error);
}

static bool encode(emit_format format) {
  static const double numbers[1000];
  emit *e = emit_new(format);
  if (e == NULL) return false;
  emit_list(e);
  for (int k = 0; k < 100; k++) emit_text(e, "some text");
  emit_doubles(e, numbers, 2, (int64_t[]){500, 2});
  emit_end(e);
  bool fine = emit_ok(e);
  emit_free(&e);
  return fine;
}

static bool encode_json(void) {
  return encode(EMIT_JSON);
}

static bool encode_cbor(void) {
  return encode(EMIT_CBOR);
}

/* Packs (where only the first allocation is needed, the second trims) and unpacks. */
static void unpack_each(coding c, const char *text, size_t size) {
  void *packed, *back;
  size_t packed_size, back_size;
  int64_t granted = 0;
  scarce_after(0, false);
  assert_int_equal(deflate_bytes(c, text, size, &packed, &packed_size), INFLATE_MEMORY);
  assert_true(scarce_end());
  assert_null(packed);
  scarce_after(1, false);
  assert_int_equal(deflate_bytes(c, text, size, &packed, &packed_size), INFLATE_OK);
  assert_true(scarce_end());
  for (bool failed = true; failed; granted++) {
    scarce_after(granted, false);
    inflate_status status = inflate_bytes(c, packed, packed_size, size, &back, &back_size);
    failed = scarce_end();
    assert_int_equal(status, failed ? INFLATE_MEMORY : INFLATE_OK);
    assert_true((back == NULL) == failed);
  }
  assert_true(granted > 2);
  assert_memory_equal(back, text, size);
  free(back);
  free(packed);
}

static void test_decode_json(void **state) {
  /* cJSON's own allocations count too. */
  cJSON_Hooks hooks = {malloc, free};
  (void)state;
  cJSON_InitHooks(&hooks);
  fail_each(decode_json);
  cJSON_InitHooks(NULL);
}

static void test_decode_cbor(void **state) {
  (void)state;
  fail_each(decode_cbor);
}

static void test_encode(void **state) {
  (void)state;
  fail_each(encode_json);
  fail_each(encode_cbor);
}

static void test_unpack(void **state) {
  enum { SIZE = 100000 };
  char *text = calloc(SIZE, 1);
  (void)state;
  for (int c = 0; c < CODING_COUNT; c++) unpack_each((coding)c, text, SIZE);
  free(text);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_decode_json),
      cmocka_unit_test(test_decode_cbor),
      cmocka_unit_test(test_encode),
      cmocka_unit_test(test_unpack),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
