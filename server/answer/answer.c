#include "answer.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cloud_input.h"
#include "expression.h"
#include "inflate.h"
#include "perform.h"
#include "scatter/solve.h"
#include "um_bridge.h"

/* Problems */

static void reply_problem(reply *r, const problem *p) {
  r->status = p->status;
  r->coding = CODING_IDENTITY;
  snprintf(r->type, sizeof r->type, "%s", media_type(MEDIA_PROBLEM));
  r->bytes = problem_bytes(p, &r->size);
}

/* HTTP status of a failure, and whether the text says what a client could do. */
static int status_of(sct_status code) {
  static const int statuses[SCT_STATUS_COUNT] = {
      [SCT_OK] = 500,           [SCT_E_ARGUMENT] = 400,
      [SCT_E_MEMORY] = 422,     [SCT_E_LIMIT] = 422,
      [SCT_E_NOT_FINITE] = 422, [SCT_E_COINCIDENT] = 400,
      [SCT_E_DEFICIENT] = 422,  [SCT_E_SINGULAR] = 422,
      [SCT_E_UNSTABLE] = 422,   [SCT_E_CONVERGENCE] = 422,
      [SCT_E_CANCELLED] = 503,
  };
  return statuses[code];
}

/* The culprit `point`, of posted points by its own pointer. */
static void add_point(problem *p, const cloud_input *c, int64_t point, const char *detail) {
  char pointer[PROBLEM_POINTER], where[96];
  const double *x = c->posted + point * c->cloud.dim;
  int used = snprintf(where, sizeof where, "%.6g", x[0]);
  for (int a = 1; a < c->cloud.dim; a++) {
    used += snprintf(where + used, sizeof where - (size_t)used, ", %.6g", x[a]);
  }
  snprintf(pointer, sizeof pointer, "%s", c->pointer);
  size_t end = strlen(pointer);
  if (!c->is_lattice) snprintf(pointer + end, sizeof pointer - end, "/%lld", (long long)point);
  problem_add(p, pointer, "point %lld at (%s): %s", (long long)point, where, detail);
}

/* All points of an error, as far as it keeps them. */
static void add_points(problem *p, const cloud_input *c, const sct_error *error) {
  int64_t kept = error->count < SCT_ERROR_POINTS ? error->count : SCT_ERROR_POINTS;
  for (int64_t k = 0; k < kept; k++) {
    bool is_subject = error->points[k] == error->point;
    const char *detail = is_subject ? error->text : sct_status_text(error->code);
    if (error->points[k] >= 0 && error->points[k] < c->cloud.n) {
      add_point(p, c, error->points[k], detail);
    }
  }
}

static void reply_failure(reply *r, task *t) {
  char message[SCT_ERROR_TEXT + 256];
  problem p;
  sct_error *error = &t->error;
  if (t->cloud) cloud_input_translate(t->cloud, error);
  sct_error_message(error, message, sizeof message);
  if (error->code == SCT_E_MEMORY) {
    problem_begin(&p, status_of(error->code), "out of memory (%s), a worker may have %lld bytes",
                  message, (long long)t->limits->memory_bytes);
  } else {
    problem_begin(&p, status_of(error->code), "%s: %s", sct_status_text(error->code), message);
  }
  if (t->blame) problem_add(&p, t->blame, "%s", error->text);
  if (t->cloud) add_points(&p, t->cloud, error);
  if (p.count == 0 && p.status == 400) problem_add(&p, "/inputs", "%s", message);
  reply_problem(r, &p);
}

/* The detail of all is that of the first, and how many more there are. */
static void reply_complaints(reply *r, task *t) {
  problem *all = &t->complaints;
  const char *pointer = all->errors[0].pointer;
  char more[32] = "";
  problem p;
  if (all->found > 1) snprintf(more, sizeof more, " (and %d more)", all->found - 1);
  problem_begin(&p, 400, "%s: %s%s", *pointer ? pointer : "the body", all->errors[0].detail, more);
  memcpy(all->detail, p.detail, sizeof p.detail);
  all->status = p.status;
  all->type = p.type;
  reply_problem(r, all);
}

/* Steps */

/* Undoes the content coding; *plain is to be freed, NULL where the body is plain already. */
static bool unpack(const ask *a, void **plain, size_t *size, reply *r) {
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
  reply_problem(r, &p);
  return false;
}

static const doc *decode(const ask *a, const void *body, size_t size, task *t, reply *r) {
  const doc_limits most = {(int)a->limits->depth, a->limits->nodes, a->limits->decoded_bytes / 2};
  doc_error error = {0};
  const doc *root = a->content == MEDIA_CBOR ? doc_from_cbor(body, size, &most, &t->arena, &error)
                                             : doc_from_json(body, size, &most, &t->arena, &error);
  stopwatch_lap(&t->watch, LAP_DECODE);
  if (root) return root;
  problem p;
  const char *form = a->content == MEDIA_CBOR ? "CBOR" : "JSON";
  problem_begin(&p, error.too_large ? 413 : 400, "the body is %s %s: %s",
                error.too_large ? "too large for the limits of" : "not valid", form, error.text);
  problem_add(&p, error.pointer, "%s", error.text);
  reply_problem(r, &p);
  return NULL;
}

/* The bytes of the result, compressed if that is wanted and worth it. */
static bool pack(const ask *a, const emit *e, reply *r) {
  enum { WORTH = 1024 }; /* bytes: what fits into one packet gains nothing */
  size_t size = 0;
  const void *bytes = emit_bytes(e, &size);
  r->coding = size >= WORTH ? a->accept_coding : CODING_IDENTITY;
  return deflate_bytes(r->coding, bytes, size, &r->bytes, &r->size) == INFLATE_OK;
}

static bool reply_result(const ask *a, task *t, performance *f, reply *r) {
  emit *e = perform_run(t, f, a->accept);
  if (!e) return false;
  bool done = pack(a, e, r);
  emit_free(&e);
  if (!done) (void)sct_fail(&t->error, SCT_E_MEMORY, -1, "no memory for the result");
  r->status = 200;
  snprintf(r->type, sizeof r->type, "%s", media_type(a->accept));
  return done;
}

/* Reads, runs and writes one decoded request. */
static void reply_to(const ask *a, const process *p, const doc *root, task *t, reply *r) {
  performance f;
  perform_read(t, p, root, a->accept, &f);
  bool done = reply_result(a, t, &f, r);
  if (!done && t->complaints.found > 0) {
    reply_complaints(r, t);
  } else if (!done) {
    reply_failure(r, t);
  }
  if (t->cloud) r->points = t->cloud->cloud.n;
  perform_clear(&f);
}

void answer_prepare(void) {
  sct_solver_prepare();
}

void answer(const ask *a, reply *r) {
  if (um_bridge_is(a->process)) {
    um_bridge_answer(a, r);
    return;
  }
  task t = {.limits = a->limits, .work = {(int)a->limits->threads, a->report, a->context}};
  const process *p = process_find(a->process);
  const doc *root = NULL;
  void *plain = NULL;
  size_t size = 0;
  *r = (reply){.status = 500};
  stopwatch_start(&t.watch);
  if (!p) {
    problem missing;
    problem_begin_type(&missing, PROBLEM_NO_SUCH_PROCESS, 404, "there is no process \"%s\"",
                       a->process);
    reply_problem(r, &missing);
    return;
  }
  if (unpack(a, &plain, &size, r)) root = decode(a, plain ? plain : a->body, size, &t, r);
  if (root) reply_to(a, p, root, &t, r);
  language_free(&t.language);
  doc_arena_free(&t.arena);
  free(plain);
}
