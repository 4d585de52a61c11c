#include "result.h"

#include <string.h>

#include "cloud_input.h"
#include "member.h"

static const char VERSION[] = "result 1";

enum { FIELDS = 1 << OUTPUT_FIELD | 1 << OUTPUT_COUNTS | 1 << OUTPUT_TENSOR };

/* Writing */

static void write_stored_output(emit *e, const task *t, const performance *f, int k) {
  const process_output *output = &f->process->outputs[k];
  const media format = f->wanted.format[k];
  emit_key(e, output->name);
  emit_object(e);
  member_bool(e, "reference", f->wanted.by_reference & 1u << k);
  if (format != MEDIA_COUNT) member_text(e, "format", media_type(format));
  emit_key(e, "value");
  output->write(e, t, f->state);
  emit_end(e);
}

static unsigned wanted_roles(const performance *f) {
  unsigned roles = 0;
  for (int k = 0; f->process->outputs[k].name; k++) {
    if (f->wanted.wanted & 1u << k) roles |= 1u << f->process->outputs[k].role;
  }
  return roles;
}

void result_write(emit *e, const task *t, const performance *f) {
  const unsigned roles = wanted_roles(f);
  emit_object(e);
  member_text(e, "scatterd", VERSION);
  member_text(e, "process", f->process->id);
  member_bool(e, "raw", f->wanted.is_raw);
  member_integer(e, "points", t->cloud ? t->cloud->cloud.n : 0);
  member_object(e, "outputs");
  for (int k = 0; f->process->outputs[k].name; k++) {
    if (f->wanted.wanted & 1u << k) write_stored_output(e, t, f, k);
  }
  emit_end(e);
  if ((roles & FIELDS) && !(roles & 1u << OUTPUT_COORDINATES) && f->process->coordinates) {
    emit_key(e, "coordinates");
    f->process->coordinates(e, t, f->state);
  }
  emit_end(e);
}

/* Reading */

static const process_output *known_output(const process *p, const char *name) {
  for (int k = 0; p->outputs[k].name; k++) {
    if (!strcmp(p->outputs[k].name, name)) return &p->outputs[k];
  }
  return NULL;
}

static bool is_true(const doc *d) {
  return d && d->kind == DOC_BOOL && d->truth;
}

static const char *text_of(const doc *d) {
  return d && d->kind == DOC_TEXT ? d->text : "";
}

static bool is_array(const doc *d) {
  return d->kind == DOC_NUMBERS && d->rank <= 2;
}

static bool read_stored_output(const process *p, const doc *stored, result_output *o) {
  const process_output *known = known_output(p, stored->key);
  const doc *value = doc_member(stored, "value"), *format = doc_member(stored, "format");
  if (!known || !value) return false;
  *o = (result_output){.name = known->name,
                       .role = known->role,
                       .is_object = known->is_object,
                       .by_reference = is_true(doc_member(stored, "reference")),
                       .format = MEDIA_COUNT,
                       .value = value};
  if (format && !media_find(text_of(format), &o->format)) return false;
  return o->role == OUTPUT_OTHER || o->role == OUTPUT_ARRAY || is_array(value);
}

static bool read_stored_outputs(const doc *outputs, result *r) {
  if (!outputs || outputs->kind != DOC_OBJECT) return false;
  for (const doc *m = outputs->child; m; m = m->next) {
    if (r->count == PROCESS_OUTPUTS_MAX) return false;
    if (!read_stored_output(r->process, m, &r->output[r->count])) return false;
    r->count++;
  }
  return true;
}

static const doc *find_coordinates(const doc *stored, const result *r) {
  for (int k = 0; k < r->count; k++) {
    if (r->output[k].role == OUTPUT_COORDINATES) return r->output[k].value;
  }
  const doc *d = doc_member(stored, "coordinates");
  return d && is_array(d) ? d : NULL;
}

bool result_read(task *t, const doc *stored, result *r) {
  const doc *points = doc_member(stored, "points");
  *r = (result){.process = process_find(text_of(doc_member(stored, "process"))),
                .is_raw = is_true(doc_member(stored, "raw"))};
  bool is_known = !strcmp(text_of(doc_member(stored, "scatterd")), VERSION) && r->process;
  if (!is_known || !read_stored_outputs(doc_member(stored, "outputs"), r)) {
    (void)sct_fail(&t->error, SCT_E_ARGUMENT, -1, "the body is no stored result of this version");
    return false;
  }
  if (points && points->kind == DOC_NUMBER) r->points = (int64_t)points->number;
  r->coordinates = find_coordinates(stored, r);
  return true;
}

const result_output *result_find(const result *r, const char *name) {
  for (int k = 0; k < r->count; k++) {
    if (!strcmp(r->output[k].name, name)) return &r->output[k];
  }
  return NULL;
}

unsigned result_roles(const result *r) {
  unsigned roles = 0;
  for (int k = 0; k < r->count; k++) roles |= 1u << r->output[k].role;
  return roles;
}
