#include "body.h"

#include "inflate.h"
#include "refusal.h"

bool body_unpack(const ask *a, void **plain, size_t *size, reply *r) {
  problem p;
  size_t most = (size_t)a->limits->decoded_bytes;
  *size = a->size;
  if (a->content_coding == CODING_IDENTITY && a->size <= most) return true;
  inflate_status status = inflate_bytes(a->content_coding, a->body, a->size, most, plain, size);
  if (status == INFLATE_OK) return true;
  int code = status == INFLATE_TOO_LARGE ? 413 : status == INFLATE_MEMORY ? 422 : 400;
  problem_begin(&p, code, "%s body: %s; at most %lld bytes may come out",
                coding_name(a->content_coding), inflate_text(status),
                (long long)a->limits->decoded_bytes);
  refuse(r, &p);
  return false;
}

static const char *const form_names[MEDIA_COUNT] = {
    [MEDIA_JSON] = "JSON", [MEDIA_CBOR] = "CBOR", [MEDIA_NPY] = "npy", [MEDIA_CSV] = "CSV"};

const doc *body_decode(const ask *a, const void *body, size_t size, task *t, reply *r) {
  const doc_limits most = {(int)a->limits->depth, a->limits->nodes, a->limits->decoded_bytes / 2};
  doc_error error = {0};
  const doc *root = doc_from(a->content, body, size, &most, &t->arena, &error);
  stopwatch_lap(&t->watch, LAP_DECODE);
  if (root) return root;
  problem p;
  problem_begin(&p, error.too_large ? 413 : 400, "the body is %s %s: %s",
                error.too_large ? "too large for the limits of" : "not valid",
                form_names[a->content], error.text);
  problem_add(&p, error.pointer, "%s", error.text);
  refuse(r, &p);
  return NULL;
}
