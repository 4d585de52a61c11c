#include "model_error.h"

#include <stdlib.h>
#include <string.h>

#include "emit.h"

static const struct {
  int status;
  const char *type;
} types[] = {{401, "Unauthorized"},    {403, "Forbidden"},          {421, "Forbidden"},
             {429, "TooManyRequests"}, {503, "ServiceUnavailable"}, {507, "ServiceUnavailable"}};

const char *model_error_type(int status) {
  for (size_t k = 0; k < sizeof types / sizeof *types; k++) {
    if (types[k].status == status) return types[k].type;
  }
  return status < 500 ? "InvalidInput" : "InvalidOutput";
}

static void emit_member(emit *e, const char *key, const char *text) {
  emit_key(e, key);
  emit_text(e, text);
}

static void emit_error(emit *e, const char *type, const char *message) {
  emit_object(e);
  emit_key(e, "error");
  emit_object(e);
  emit_member(e, "type", type);
  emit_member(e, "message", message);
  emit_end(e);
  emit_end(e);
}

char *model_error_bytes(const char *type, const char *message, size_t *size) {
  char *copy = NULL;
  emit *e = emit_new(EMIT_JSON);
  if (e == NULL) return NULL;
  emit_error(e, type, message);
  const void *bytes = emit_ok(e) ? emit_bytes(e, size) : NULL;
  if (bytes != NULL) copy = malloc(*size + 1);
  if (copy != NULL) {
    memcpy(copy, bytes, *size);
    copy[*size] = '\0';
  }
  emit_free(&e);
  return copy;
}
