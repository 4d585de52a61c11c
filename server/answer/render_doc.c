/* render_doc.c - the results document, and one bare value, as JSON and CBOR. */
#include <stdlib.h>
#include <string.h>

#include "base64.h"
#include "member.h"
#include "render_back.h"

static void write_link(emit *e, const result_output *o) {
  emit_object(e);
  member_text(e, "href", o->href);
  member_text(e, "type", media_type(render_own_form(o)));
  emit_end(e);
}

/* Integers are numbers in a document; CBOR tells them apart. */
static void write_value(task *t, emit *e, const result_output *o) {
  const doc *d = o->value;
  if (o->role != OUTPUT_COUNTS || d->kind != DOC_NUMBERS) {
    emit_doc(e, d);
    return;
  }
  int32_t *value = task_take(t, d->count, sizeof *value);
  if (!value) return;
  for (int64_t k = 0; k < d->count; k++) value[k] = render_integer(d->data[k]);
  emit_int32s(e, value, d->rank, d->shape);
}

/* {"value": base64, "encoding": "base64", "mediaType": ...}: a form of its own within a document.
 */
static bool write_encoded(task *t, emit *e, const result *r, const result_output *o) {
  rendered own = {0};
  char *text = NULL;
  size_t length = 0;
  bool done = render_in(t, r, o, o->format, &own);
  if (done) text = base64_encode(own.bytes.data, own.bytes.size, &length);
  if (done && !text) (void)sct_fail(&t->error, SCT_E_MEMORY, -1, "no memory for the result");
  if (text) {
    emit_object(e);
    emit_key(e, "value");
    emit_text_n(e, text, length);
    member_text(e, "encoding", "base64");
    member_text(e, "mediaType", media_type(o->format));
    emit_end(e);
  }
  free(text);
  free(own.bytes.data);
  return text != NULL;
}

static bool write_member(task *t, emit *e, media form, const result *r, const result_output *o) {
  const bool is_foreign = o->format != MEDIA_COUNT && o->format != MEDIA_JSON && o->format != form;
  emit_key(e, o->name);
  if (o->by_reference) {
    write_link(e, o);
  } else if (is_foreign) {
    return write_encoded(t, e, r, o);
  } else if (o->is_object) {
    emit_object(e);
    emit_key(e, "value");
    write_value(t, e, o);
    emit_end(e);
  } else {
    write_value(t, e, o);
  }
  return true;
}

static bool write_document(task *t, emit *e, media form, const result *r) {
  bool done = true;
  emit_object(e);
  for (int k = 0; done && k < r->count; k++) done = write_member(t, e, form, r, &r->output[k]);
  emit_end(e);
  return done;
}

static bool render_as(task *t, media form, const result *r, const result_output *one,
                      rendered *out) {
  emit *e = emit_new(form == MEDIA_CBOR ? EMIT_CBOR : EMIT_JSON);
  bool done = e != NULL;
  size_t size = 0;
  if (done && one) write_value(t, e, one);
  if (done && !one) done = write_document(t, e, form, r);
  done = done && emit_ok(e) && t->error.code == SCT_OK;
  if (!done && t->error.code == SCT_OK) {
    (void)sct_fail(&t->error, SCT_E_MEMORY, -1, "no memory for the result");
  }
  if (done && out->bytes.size == 0) { /* the usual case: no copy */
    free(out->bytes.data);
    out->bytes = (grow_bytes){0};
    out->bytes.data = emit_take(e, &size);
    out->bytes.size = out->bytes.capacity = size;
  } else if (done) {
    const void *bytes = emit_bytes(e, &size);
    done = put(t, out, bytes, size);
  }
  emit_free(&e);
  return done;
}

bool render_json(task *t, const result *r, const result_output *one, rendered *out) {
  return render_as(t, MEDIA_JSON, r, one, out);
}

bool render_cbor(task *t, const result *r, const result_output *one, rendered *out) {
  return render_as(t, MEDIA_CBOR, r, one, out);
}
