#include "asking.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "emit.h"
#include "inflate.h"

limits asking_limits(void) {
  return (limits){.body_bytes = 1 << 24,
                  .decoded_bytes = 1 << 26,
                  .depth = 32,
                  .nodes = 100000,
                  .points = 200000,
                  .neighbours = 500,
                  .expression_bytes = 4096,
                  .expression_work = 1000000000,
                  .steps = 100000,
                  .memory_bytes = INT64_C(1) << 32,
                  .seconds = 60,
                  .threads = 1};
}

asked ask_all(const ask *question) {
  const doc_limits most = {64, 1 << 20, 1 << 24};
  asked a = {0};
  doc_error error;
  void *plain = NULL;
  size_t size = 0;
  answer(question, &a.raw);
  assert_non_null(a.raw.bytes);
  assert_int_equal(INFLATE_OK,
                   inflate_bytes(a.raw.coding, a.raw.bytes, a.raw.size, 1 << 27, &plain, &size));
  bool is_cbor = !strcmp(a.raw.type, "application/cbor");
  a.root = is_cbor ? doc_from_cbor(plain, size, &most, &a.arena, &error)
                   : doc_from_json(plain, size, &most, &a.arena, &error);
  if (!a.root) fail_msg("reply cannot be decoded: %s\n%.*s", error.text, (int)size, (char *)plain);
  free(plain);
  return a;
}

asked ask_json(const char *process, const char *body) {
  const limits most = asking_limits();
  const ask question = {.process = process,
                        .body = body,
                        .size = strlen(body),
                        .content = MEDIA_JSON,
                        .accept = media_wish(MEDIA_JSON),
                        .limits = &most};
  return ask_all(&question);
}

void asked_clear(asked *a) {
  doc_arena_free(&a->arena);
  free(a->raw.bytes);
  *a = (asked){0};
}

const doc *at_pointer(const doc *root, const char *pointer) {
  char step[64];
  while (root && *pointer == '/') {
    size_t length = strcspn(++pointer, "/");
    snprintf(step, sizeof step, "%.*s", (int)length, pointer);
    root = root->kind == DOC_OBJECT ? doc_member(root, step) : doc_at(root, atoi(step));
    pointer += length;
  }
  return root;
}

double number_at(const doc *root, const char *pointer) {
  const doc *d = at_pointer(root, pointer);
  if (!d || d->kind != DOC_NUMBER) fail_msg("there is no number at %s", pointer);
  return d->number;
}

const double *numbers_at(const doc *root, const char *pointer, int64_t count) {
  const doc *d = at_pointer(root, pointer);
  if (!d || d->kind != DOC_NUMBERS || d->count != count) {
    fail_msg("there are no %lld numbers at %s", (long long)count, pointer);
  }
  return d->data;
}

void *cbor_of(const char *json, size_t *size) {
  const doc_limits most = {64, 1 << 20, 1 << 24};
  doc_arena *arena;
  doc_error error;
  const doc *root = doc_from_json(json, strlen(json), &most, &arena, &error);
  assert_non_null(root);
  emit *e = emit_new(EMIT_CBOR);
  emit_doc(e, root);
  assert_true(emit_ok(e));
  const void *bytes = emit_bytes(e, size);
  void *copy = malloc(*size);
  memcpy(copy, bytes, *size);
  emit_free(&e);
  doc_arena_free(&arena);
  return copy;
}

const char *culprits_of(const asked *a, char *room, size_t size) {
  const doc *errors = at_pointer(a->root, "/errors");
  size_t used = 0;
  room[0] = '\0';
  for (const doc *d = errors ? errors->child : NULL; d && used < size; d = d->next) {
    const doc *pointer = doc_member(d, "pointer");
    used += (size_t)snprintf(room + used, size - used, "%s%s", used ? " " : "", pointer->text);
  }
  return room;
}
