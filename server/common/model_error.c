#include "model_error.h"

#include "member.h"

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

static void emit_error(emit *e, const char *type, const char *message) {
  emit_object(e);
  member_object(e, "error");
  member_text(e, "type", type);
  member_text(e, "message", message);
  emit_end(e);
  emit_end(e);
}

char *model_error_bytes(const char *type, const char *message, size_t *size) {
  emit *e = emit_new(EMIT_JSON);
  if (e == NULL) return NULL;
  emit_error(e, type, message);
  char *text = emit_take_text(e, size);
  emit_free(&e);
  return text;
}
