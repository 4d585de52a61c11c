/* Random damage to good bodies: the decoder takes or refuses, and what it takes is a document that
 * goes to both formats and comes back the same. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "doc_back.h"
#include "emit.h"
#include "seed.h"

enum { MUTATIONS = 30000 };

static const doc_limits limits = {.depth = 12, .nodes = 200, .numbers = 500};

static const char *const samples[] = {
    "{\"inputs\":{\"cloud\":{\"points\":[[0,0],[1,0],[0.5,1e-3]],\"spacing\":0.5},"
    "\"diffusivity\":1.5,\"velocity\":[\"1\",\"x*y\"],\"boundary\":[{\"on\":\"left\",\"value\":0},"
    "{\"on\":[0,1,2],\"value\":[1,2,3]}]}}",
    "[[[1,2],[3,4]],[[5,6],[7,8]],[[9,-0],[1e300,4.9e-324]]]",
    "[\"\\ud83d\\ude00\\n\\u0000\",\"\u00e9\u6c34\U0001F600\",true,false,null,{},[],[[]],[{}]]",
    "{\"a\":{\"b\":{\"c\":{\"d\":[[1,2],[3],[],\"x\"]}}},\"e\":-1.25e-7,\"f\":NaN,\"g\":[Infinity]"
    "}",
};
enum { SAMPLES = sizeof samples / sizeof samples[0] };

typedef struct {
  unsigned char *bytes;
  size_t size;
} blob;

static const doc *decode(emit_format format, blob b, doc_arena **arena, doc_error *error) {
  return format == EMIT_JSON ? doc_from_json((const char *)b.bytes, b.size, &limits, arena, error)
                             : doc_from_cbor(b.bytes, b.size, &limits, arena, error);
}

static blob encode(emit_format format, const doc *d) {
  blob b;
  emit *e = emit_new(format);
  emit_doc(e, d);
  assert_true(emit_ok(e));
  const void *bytes = emit_bytes(e, &b.size);
  b.bytes = malloc(b.size);
  memcpy(b.bytes, bytes, b.size);
  emit_free(&e);
  return b;
}

/* ---- damage: each changes a copy with room for twice its size ---- */

static void flip(blob *b, blob other, uint64_t *r) {
  (void)other;
  b->bytes[seed_below(r, (int)b->size)] ^= (unsigned char)(1 << seed_below(r, 8));
}

static void set(blob *b, blob other, uint64_t *r) {
  static const unsigned char likely[] = "[]{},:\"\\0-.e1 \x80\xFF\xFE\x9F\xBF\xD8\x5F\x7F\x1B\xF6";
  (void)other;
  int k = seed_below(r, (int)b->size);
  b->bytes[k] = likely[seed_below(r, sizeof likely)];
}

static void cut(blob *b, blob other, uint64_t *r) {
  (void)other;
  b->size = (size_t)seed_below(r, (int)b->size) + 1;
}

static void drop(blob *b, blob other, uint64_t *r) {
  (void)other;
  size_t from = (size_t)seed_below(r, (int)b->size);
  size_t n = (size_t)seed_below(r, (int)(b->size - from)) / 4 + 1;
  if (n >= b->size) return;
  memmove(b->bytes + from, b->bytes + from + n, b->size - from - n);
  b->size -= n;
}

/* A piece of another sample, in. */
static void splice(blob *b, blob other, uint64_t *r) {
  size_t from = (size_t)seed_below(r, (int)other.size);
  size_t n = (size_t)seed_below(r, (int)(other.size - from)) / 4 + 1;
  size_t at = (size_t)seed_below(r, (int)b->size);
  memmove(b->bytes + at + n, b->bytes + at, b->size - at);
  memcpy(b->bytes + at, other.bytes + from, n);
  b->size += n;
}

typedef void mutation(blob *b, blob other, uint64_t *r);
static mutation *const mutations[] = {flip, set, cut, drop, splice};
enum { KINDS = sizeof mutations / sizeof mutations[0] };

static blob mutate(blob good, blob other, uint64_t *r) {
  size_t room = good.size + 4 * other.size;
  blob b = {malloc(room), good.size};
  memcpy(b.bytes, good.bytes, good.size);
  for (int k = 1 + seed_below(r, 4); k > 0; k--) mutations[seed_below(r, KINDS)](&b, other, r);
  b.bytes = realloc(b.bytes, b.size); /* no byte beyond: a sanitizer sees a step too far */
  return b;
}

/* ---- what must hold ---- */

static void check_error(const doc_error *error, size_t size) {
  assert_true(error->offset >= 0 && error->offset <= (int64_t)size);
  assert_true(error->text[0] != '\0' && memchr(error->text, 0, sizeof error->text) != NULL);
  assert_true(error->pointer[0] == '\0' || error->pointer[0] == '/');
}

static void check_back(const doc *d, emit_format format) {
  char *wrong = doc_back(d, format);
  if (wrong != NULL) fail_msg("%s", wrong);
}

static bool check(emit_format format, blob b) {
  doc_arena *arena;
  doc_error error;
  const doc *d = decode(format, b, &arena, &error);
  if (d == NULL) {
    check_error(&error, b.size);
  } else {
    check_back(d, EMIT_JSON);
    check_back(d, EMIT_CBOR);
  }
  doc_arena_free(&arena);
  return d != NULL;
}

static void mutate_all(emit_format format) {
  uint64_t r = seed_new(format == EMIT_JSON ? "unit.doc_mutation json" : "unit.doc_mutation cbor");
  blob good[SAMPLES];
  int taken = 0;
  for (int k = 0; k < SAMPLES; k++) {
    doc_arena *arena;
    doc_error error;
    blob json = {(unsigned char *)samples[k], strlen(samples[k])};
    const doc *d = decode(EMIT_JSON, json, &arena, &error);
    assert_non_null(d);
    good[k] = encode(format, d);
    doc_arena_free(&arena);
    assert_true(check(format, good[k]));
  }
  for (int k = 0; k < MUTATIONS; k++) {
    blob b = mutate(good[k % SAMPLES], good[seed_below(&r, SAMPLES)], &r);
    taken += check(format, b);
    free(b.bytes);
  }
  printf("%d of %d taken\n", taken, MUTATIONS);
  assert_true(taken > MUTATIONS / 1000 && taken < MUTATIONS);
  for (int k = 0; k < SAMPLES; k++) free(good[k].bytes);
}

static void test_json(void **state) {
  (void)state;
  mutate_all(EMIT_JSON);
}

static void test_cbor(void **state) {
  (void)state;
  mutate_all(EMIT_CBOR);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_json),
      cmocka_unit_test(test_cbor),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
