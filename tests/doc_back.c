#include "doc_back.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "doc_show.h"

/* Null for NaN makes a list of an array: more nodes than were decoded. */
static const doc_limits wide = {.depth = 100, .nodes = 1000000, .numbers = 10000000};

static char *complaint(const char *what, const char *of) {
  size_t size = strlen(what) + strlen(of) + 3;
  char *text = malloc(size);
  snprintf(text, size, "%s: %s", what, of);
  return text;
}

static char *compare(const doc *d, const doc *again) {
  char *before = doc_show(d), *after = doc_show(again), *wrong = NULL;
  bool finite = strstr(before, "nan") == NULL && strstr(before, "inf") == NULL;
  if (finite && strcmp(before, after) != 0) wrong = complaint(before, after);
  free(before);
  free(after);
  return wrong;
}

char *doc_back(const doc *d, emit_format format) {
  size_t size;
  doc_arena *arena;
  doc_error error;
  emit *e = emit_new(format);
  emit_doc(e, d);
  if (!emit_ok(e)) {
    emit_free(&e);
    return complaint("emit", "failed");
  }
  const void *bytes = emit_bytes(e, &size);
  const doc *again = format == EMIT_JSON ? doc_from_json(bytes, size, &wide, &arena, &error)
                                         : doc_from_cbor(bytes, size, &wide, &arena, &error);
  char *wrong = again == NULL ? complaint("own output refused", error.text) : compare(d, again);
  doc_arena_free(&arena);
  emit_free(&e);
  return wrong;
}
