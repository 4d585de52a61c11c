#include "study_run.h"

#include <stdio.h>
#include <string.h>

#include "template.h"

static const doc_limits OWN = {DOC_DEPTH_MAX, INT64_C(1) << 24, INT64_C(1) << 40};

/* The request */

static void write_outputs(emit *e, const doc *names) {
  emit_key(e, "outputs");
  emit_object(e);
  for (const doc *name = names->child; name; name = name->next) {
    emit_key(e, name->text);
    emit_object(e);
    emit_end(e);
  }
  emit_end(e);
}

static void write_request(emit *e, study_run *r) {
  const doc *template = doc_member(r->in->root, "request");
  emit_object(e);
  emit_key(e, "inputs");
  emit_object(e);
  for (const doc *m = template->child; m; m = m->next) {
    emit_key(e, m->key);
    template_write(e, m, &r->names);
  }
  emit_key(e, "operator");
  emit_doc(e, r->in->operator_doc);
  emit_end(e);
  write_outputs(e, doc_member(r->in->root, "outputs"));
  emit_end(e);
}

/* What was written, as a document. */
static const doc *settle(task *t, emit *e, doc_arena **arena) {
  doc_error error;
  size_t size = 0;
  const void *bytes = e && emit_ok(e) ? emit_bytes(e, &size) : NULL;
  const doc *d = bytes ? doc_from_cbor(bytes, size, &OWN, arena, &error) : NULL;
  if (!d) (void)sct_fail(&t->error, SCT_E_MEMORY, -1, "no memory for a request or its result");
  return d;
}

/* `measured` is a name of the scope where the case has something to measure. */
static bool make_request(task *t, int64_t cloud, double measured, study_run *r) {
  const doc *before = doc_member(r->in->root, "before");
  if (!study_input_scope(t, r->in, r->row, cloud, &r->names)) return false;
  if (before && !scope_set(&r->names, doc_member(before, "name")->text, measured)) return false;
  emit *e = emit_new(EMIT_CBOR);
  if (e) write_request(e, r);
  if (!t->error.code) r->request = settle(t, e, &r->request_arena);
  emit_free(&e);
  return r->request;
}

/* Failures */

static bool is_known(const problem *p, const char *pointer) {
  for (int k = 0; k < p->count; k++) {
    if (!strcmp(p->errors[k].pointer, pointer)) return true;
  }
  return false;
}

static void blame(const study_run *r, const char *pointer, char blamed[PROBLEM_POINTER]) {
  const doc *root = r->in->root;
  template_blame(root, doc_member(root, "request"), pointer, r->row % r->in->cells.rows, blamed);
}

/* The same thing is often wrong on every mesh; it is said once. */
static void pass_complaints(task *t, const study_run *r) {
  char blamed[PROBLEM_POINTER];
  for (int k = 0; k < r->own.complaints.count; k++) {
    blame(r, r->own.complaints.errors[k].pointer, blamed);
    if (is_known(&t->complaints, blamed)) continue;
    problem_add(&t->complaints, blamed, "%s", r->own.complaints.errors[k].detail);
  }
}

static void pass_error(task *t, study_run *r) {
  char *blamed = task_take(t, PROBLEM_POINTER, 1);
  if (r->own.cloud) cloud_input_translate(r->own.cloud, &r->own.error);
  t->error = r->own.error;
  if (!blamed || t->error.code == SCT_E_MEMORY || t->error.code == SCT_E_CANCELLED) return;
  blame(r, r->own.blame ? r->own.blame : "/inputs/cloud/lattice/cells", blamed);
  t->blame = blamed;
}

/* The run */

static bool tell(void *context, const char *phase, double fraction) {
  const study_run *r = context;
  const sct_work *work = &r->outer->work;
  char room[64];
  (void)fraction;
  snprintf(room, sizeof room, "%.12s, row %lld of %lld", phase, (long long)r->row + 1,
           (long long)r->in->rows);
  return !work->report || work->report(work->context, room, r->fraction);
}

bool study_run_open(task *t, const study_input *in, int64_t row, int64_t cloud, double measured,
                    study_run *r) {
  *r = (study_run){.in = in, .row = row, .outer = t};
  if (!make_request(t, cloud, measured, r)) return false;
  r->own = (task){.limits = t->limits, .work = {t->work.threads, tell, r}};
  r->own.arena = doc_arena_new();
  if (!r->own.arena) (void)sct_fail(&t->error, SCT_E_MEMORY, -1, "no memory for a run");
  if (!r->own.arena) return false;
  stopwatch_start(&r->own.watch);
  perform_read(&r->own, process_find(doc_member(in->root, "process")->text), r->request, &r->work);
  pass_complaints(t, r);
  if (r->own.error.code) pass_error(t, r);
  return task_is_well(t);
}

/* Books where the time of a run went. */
static void book(task *t, const stopwatch *watch) {
  stopwatch_lap(&t->watch, LAP_SOLVE);
  for (int k = 0; k < LAP_COUNT; k++) {
    if (k != LAP_SOLVE) stopwatch_move(&t->watch, LAP_SOLVE, (lap)k, watch->seconds[k]);
  }
}

const doc *study_run_perform(task *t, study_run *r, double fraction) {
  r->fraction = fraction;
  emit *e = perform_run(&r->own, &r->work, PERFORM_CBOR);
  const doc *result = NULL;
  if (e) {
    stopwatch_lap(&r->own.watch, LAP_ENCODE);
    result = settle(t, e, &r->result_arena);
  } else {
    pass_complaints(t, r);
    if (r->own.error.code) pass_error(t, r);
  }
  emit_free(&e);
  book(t, &r->own.watch);
  return result;
}

void study_run_close(study_run *r) {
  perform_clear(&r->work);
  language_free(&r->own.language);
  scope_close(&r->names);
  doc_arena_free(&r->result_arena);
  doc_arena_free(&r->own.arena);
  doc_arena_free(&r->request_arena);
}

const doc *study_run_value(const doc *result, const char *pointer) {
  char name[64];
  size_t length = strcspn(pointer + 1, "/");
  if (length >= sizeof name) return NULL;
  memcpy(name, pointer + 1, length);
  name[length] = '\0';
  const doc *output = doc_member(result, name), *inside = doc_member(output, "value");
  return doc_at_pointer(inside ? inside : output, pointer + 1 + length);
}

/* Measuring */

/* The study with other operator and parameters, as `before` says for its scheme. */
static bool change(task *t, const doc *before, const study_input *in, study_input *other) {
  const doc *operators = doc_member(before, "operators"), *sets = doc_member(before, "parameters");
  const doc *own = doc_member(operators, sct_scheme_name(in->op.scheme));
  *other = *in;
  if (in->varied && doc_member(sets, in->varied->key)) other->varied = NULL;
  other->parameters = doc_make_object(t, NULL);
  other->operator_doc = doc_make_object(t, NULL);
  if (!other->parameters || !other->operator_doc) return false;
  return (!own || doc_add_members(t, own, other->operator_doc)) &&
         doc_add_members(t, in->operator_doc, other->operator_doc) &&
         doc_add_members(t, sets, other->parameters) &&
         doc_add_members(t, in->parameters, other->parameters);
}

bool study_run_measure(task *t, const study_input *in, int64_t row, int64_t cloud, double fraction,
                       double *measured) {
  const doc *before = doc_member(in->root, "before");
  study_input other;
  study_run run;
  *measured = 1;
  if (!before) return true;
  if (!change(t, before, in, &other)) return false;
  bool good = study_run_open(t, &other, row, cloud, 1, &run);
  const doc *result = good ? study_run_perform(t, &run, fraction) : NULL;
  const doc *found = result ? study_run_value(result, doc_member(before, "take")->text) : NULL;
  if (found) *measured = found->number;
  study_run_close(&run);
  return found;
}
