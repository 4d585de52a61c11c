#include "um_bridge.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "by_href.h"
#include "derivative.h"
#include "expression.h"
#include "member.h"
#include "model_error.h"

static const char family[] = "um-bridge/";

bool um_bridge_is(const char *id) {
  return !strncmp(id, family, sizeof family - 1);
}

/* ---- Operations ---- */

/* Each reads what it needs of the body into the zeroed *m, works, and writes the members of its
 * reply. False with complaints or t->error. */
typedef bool operate(task *t, const item *body, model *m, emit *e);

static void emit_sizes(emit *e, const char *key, int64_t count, const int64_t *size) {
  emit_key(e, key);
  emit_list(e);
  for (int64_t k = 0; k < count; k++) emit_integer(e, size[k]);
  emit_end(e);
}

static bool tell_inputs(task *t, const item *body, model *m, emit *e) {
  if (!model_read(t, body, false, m)) return false;
  int64_t *size = task_take(t, m->in.vectors, sizeof *size);
  for (int64_t k = 0; size && k < m->in.vectors; k++) size[k] = m->in.first[k + 1] - m->in.first[k];
  if (size) emit_sizes(e, "inputSizes", m->in.vectors, size);
  return size != NULL;
}

static bool tell_outputs(task *t, const item *body, model *m, emit *e) {
  if (!model_read(t, body, false, m)) return false;
  int64_t *size = task_take(t, m->outputs, sizeof *size);
  for (int64_t k = 0; size && k < m->outputs; k++) size[k] = m->output[k].size;
  if (size) emit_sizes(e, "outputSizes", m->outputs, size);
  return size != NULL;
}

static bool write_output(task *t, const model *m, int64_t k, emit *e) {
  sct_csr *rows = NULL;
  double *value = task_take(t, m->output[k].size, sizeof *value);
  if (!value || !functional_rows(t, &m->output[k], &m->solve, &rows)) return false;
  sct_csr_multiply(rows, m->solve.phi, value);
  sct_csr_free(&rows);
  emit_array(e, value, m->output[k].size);
  return true;
}

static bool evaluate(task *t, const item *body, model *m, emit *e) {
  bool good = model_read(t, body, true, m) && !solve_compute(t, &m->solve);
  if (!good) return false;
  emit_key(e, "output");
  emit_list(e);
  for (int64_t k = 0; good && k < m->outputs; k++) good = write_output(t, m, k, e);
  emit_end(e);
  return good;
}

/* What gradient and Jacobian have in common: the two vectors. */
static bool read_pair(task *t, const item *body, model *m, int64_t *out, int64_t *in) {
  if (!model_read(t, body, true, m)) return false;
  m->is_unsupported = !derivative_is_possible(m);
  if (m->is_unsupported) return false;
  const bool found = model_read_index(t, body, "outWrt", m->outputs, out);
  return model_read_index(t, body, "inWrt", m->in.vectors, in) && found;
}

/* Reads the direction `key` [of] and makes room for the result [gives]. */
static bool read_direction(task *t, const item *body, const char *key, int64_t of, int64_t gives,
                           double **direction, double **result) {
  item it = item_member(body, key);
  *direction = task_take(t, of, sizeof **direction);
  *result = task_zeros(t, gives, sizeof **result);
  return *direction && *result && model_read_vector(t, &it, of, *direction);
}

static bool gradient(task *t, const item *body, model *m, emit *e) {
  int64_t out = 0, in = 0;
  double *sens, *result;
  if (!read_pair(t, body, m, &out, &in)) return false;
  const int64_t inputs = m->in.first[in + 1] - m->in.first[in], outputs = m->output[out].size;
  if (!read_direction(t, body, "sens", outputs, inputs, &sens, &result)) return false;
  if (!derivative_gradient(t, m, out, in, sens, result)) return false;
  member_doubles(e, "output", result, inputs);
  return true;
}

static bool apply_jacobian(task *t, const item *body, model *m, emit *e) {
  int64_t out = 0, in = 0;
  double *vec, *result;
  if (!read_pair(t, body, m, &out, &in)) return false;
  const int64_t inputs = m->in.first[in + 1] - m->in.first[in], outputs = m->output[out].size;
  if (!read_direction(t, body, "vec", inputs, outputs, &vec, &result)) return false;
  if (!derivative_apply(t, m, out, in, vec, result)) return false;
  member_doubles(e, "output", result, outputs);
  return true;
}

static operate model_info;

typedef struct {
  const char *name;
  operate *run;    /* NULL: not supported */
  bool is_feature; /* listed in ModelInfo */
} operation;

static const operation operations[] = {
    {"Evaluate", evaluate, true},
    {"Gradient", gradient, true},
    {"ApplyJacobian", apply_jacobian, true},
    {"ApplyHessian", NULL, true},
    {"ModelInfo", model_info, false},
    {"InputSizes", tell_inputs, false},
    {"OutputSizes", tell_outputs, false},
};
enum { OPERATIONS = sizeof operations / sizeof *operations };

static bool model_info(task *t, const item *body, model *m, emit *e) {
  (void)t;
  (void)body;
  (void)m;
  member_object(e, "support");
  for (int k = 0; k < OPERATIONS; k++) {
    if (operations[k].is_feature) member_bool(e, operations[k].name, operations[k].run != NULL);
  }
  emit_end(e);
  return true;
}

static const operation *operation_of(const char *id) {
  const char *name = id + sizeof family - 1;
  int k = 0;
  while (k < OPERATIONS - 1 && strcmp(operations[k].name, name) != 0) k++;
  return &operations[k];
}

/* ---- Replies ---- */

static void reply_json(reply *r, int status, char *bytes) {
  r->status = status;
  snprintf(r->type, sizeof r->type, "%s", media_type(MEDIA_JSON));
  r->bytes = bytes;
}

static void reply_emitted(reply *r, int status, emit *e) {
  reply_json(r, status, e ? emit_take_text(e, &r->size) : NULL);
}

static void reply_error(reply *r, int status, const char *type, const char *format, ...)
    SCT_PRINTF(4, 5);
static void reply_error(reply *r, int status, const char *type, const char *format, ...) {
  char message[2 * PROBLEM_TEXT];
  va_list list;
  va_start(list, format);
  vsnprintf(message, sizeof message, format, list);
  va_end(list);
  reply_json(r, status, model_error_bytes(type, message, &r->size));
}

static void reply_complaints(reply *r, const problem *p) {
  char more[32] = "";
  const char *pointer = p->errors[0].pointer;
  if (p->found > 1) snprintf(more, sizeof more, " (and %d more)", p->found - 1);
  reply_error(r, 400, "InvalidInput", "%s: %s%s", *pointer ? pointer : "the body",
              p->errors[0].detail, more);
}

/* What the library says. Points and arguments that are wrong are the input's fault. */
static void reply_failure(reply *r, task *t) {
  char message[SCT_ERROR_TEXT + 256];
  const bool is_input = t->error.code == SCT_E_ARGUMENT || t->error.code == SCT_E_COINCIDENT;
  if (t->cloud) cloud_input_translate(t->cloud, &t->error);
  reply_error(r, is_input ? 400 : 500, is_input ? "InvalidInput" : "InvalidOutput", "%s: %s",
              sct_status_text(t->error.code),
              sct_error_message(&t->error, message, sizeof message));
}

static void run(const operation *o, const item *body, task *t, reply *r) {
  model m = {0};
  emit *e = emit_new(EMIT_JSON);
  if (e) emit_object(e);
  const bool good = e && o->run(t, body, &m, e);
  if (e) emit_end(e);
  if (t->cloud) r->points = t->cloud->cloud.n;
  if (good) {
    reply_emitted(r, 200, e);
  } else if (m.is_unsupported) {
    reply_error(r, 400, "UnsupportedFeature", "%s is not supported with upwind %s", o->name,
                sct_upwind_name(m.solve.in.op.upwind));
  } else if (t->complaints.found > 0) {
    reply_complaints(r, &t->complaints);
  } else if (e) {
    reply_failure(r, t);
  }
  t->cloud = NULL;
  emit_free(&e);
  model_clear(&m);
}

static void answer_to(const operation *o, const doc *root, task *t, reply *r) {
  const item body = item_body(root);
  const doc *name = doc_member(root, "name");
  if (root->kind != DOC_OBJECT) {
    reply_error(r, 400, "InvalidInput", "the body is no object");
  } else if (!name || name->kind != DOC_TEXT || strcmp(name->text, model_name) != 0) {
    char room[SHOWN_MAX];
    reply_error(r, 400, "ModelNotFound", "Model %s not supported by this server, needs \"%s\"",
                name && name->kind == DOC_TEXT ? shown(name->text, room) : "without a name",
                model_name);
  } else if (!o->run) {
    reply_error(r, 400, "UnsupportedFeature", "%s is not supported by model %s", o->name,
                model_name);
  } else {
    run(o, &body, t, r);
  }
}

void um_bridge_answer(const ask *a, reply *r) {
  by_href references = {.calls = &a->calls};
  task t = {.limits = a->limits,
            .by_href = &references,
            .work = {(int)a->limits->threads, a->calls.report, a->calls.context}};
  const doc_limits most = {(int)a->limits->depth, a->limits->nodes, a->limits->decoded_bytes / 2};
  doc_error why = {0};
  *r = (reply){.status = 500};
  stopwatch_start(&t.watch);
  const doc *root = doc_from_json(a->body, a->size, &most, &t.arena, &why);
  if (root) {
    answer_to(operation_of(a->process), root, &t, r);
  } else {
    reply_error(r, why.too_large ? 413 : 400, "InvalidInput", "the body %s: %s",
                why.too_large ? "is too large" : "is not valid JSON", why.text);
  }
  language_free(&t.language);
  doc_arena_free(&t.arena);
  by_href_clear(&references);
}
