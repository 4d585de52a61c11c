#include "answer.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "body.h"
#include "by_href.h"
#include "by_ranks.h"
#include "check.h"
#include "cloud_input.h"
#include "estimate.h"
#include "expression.h"
#include "inflate.h"
#include "perform.h"
#include "progress.h"
#include "refusal.h"
#include "render.h"
#include "report.h"
#include "scatter/solve.h"
#include "um_bridge.h"

/* Results out */

/* Hands malloc'ed bytes out, compressed if that is wanted and worth it. */
static bool pack(const ask *a, task *t, void *bytes, size_t size, reply *r) {
  enum { WORTH = 1024 }; /* bytes: what fits into one packet gains nothing */
  r->coding = size >= WORTH ? a->accept_coding : CODING_IDENTITY;
  if (r->coding == CODING_IDENTITY && bytes) {
    r->bytes = bytes;
    r->size = size;
    return true;
  }
  bool done = deflate_bytes(r->coding, bytes, size, &r->bytes, &r->size) == INFLATE_OK;
  free(bytes);
  if (!done) (void)sct_fail(&t->error, SCT_E_MEMORY, -1, "no memory for the result");
  return done;
}

static bool pack_emit(const ask *a, task *t, emit *e, media form, reply *r) {
  size_t size = 0;
  void *bytes = e ? emit_take(e, &size) : NULL;
  bool done = e && pack(a, t, bytes, size, r);
  emit_free(&e);
  r->status = 200;
  snprintf(r->type, sizeof r->type, "%s", media_type(form));
  return done;
}

/* Renders a stored result. False with the reply or t->error set. */
static bool render_stored(const ask *a, task *t, const void *bytes, size_t size, reply *r) {
  static const doc_limits most = {DOC_DEPTH_MAX, INT64_MAX / 2, INT64_MAX / 16}; /* it is ours */
  const render_wish wish = {a->output, a->results_url, a->accept, &a->calls};
  doc_arena *arena = NULL;
  doc_error error = {0};
  problem refusal = {0};
  rendered out = {0};
  result stored;
  const doc *root = doc_from_cbor(bytes, size, &most, &arena, &error);
  if (!root) {
    const sct_status code = error.too_large ? SCT_E_MEMORY : SCT_E_ARGUMENT;
    (void)sct_fail(&t->error, code, -1, "a stored result: %s", error.text);
  }
  bool done = root && result_read(t, root, &stored) && render(t, &stored, &wish, &out, &refusal);
  if (done) {
    r->status = out.status;
    r->points = stored.points;
    memcpy(r->type, out.type, sizeof r->type);
    done = pack(a, t, out.bytes.data, out.bytes.size, r);
  } else {
    free(out.bytes.data);
  }
  doc_arena_free(&arena);
  if (refusal.status) refuse(r, &refusal);
  return done;
}

/* Works: each false where something is wrong, with the reply already made or the task not well. */

static bool out_of_memory(task *t) {
  (void)sct_fail(&t->error, SCT_E_MEMORY, -1, "no memory for the reply");
  return false;
}

/* Will several processes do it together, now or when it is run as a job? */
static bool will_be_shared(const ask *a, const task *t, const performance *f) {
  if (t->ranks) return t->ranks->group != NULL;
  return a->work == IPC_CHECK && t->limits->ranks > 1 && t->cloud && f->process->alone &&
         t->cloud->cloud.n >= t->limits->executor_points && !f->process->alone(t, f->state);
}

/* A run that cannot fit is refused before it starts; the estimate goes into the reply. */
static bool fits_into_memory(const ask *a, task *t, const performance *f, reply *r) {
  problem p;
  if (!task_is_well(t)) return false;
  const int64_t processes = will_be_shared(a, t, f) ? t->limits->ranks : 1;
  t->processes = processes > 1 ? processes : 0;
  r->memory_bytes =
      estimate_shared(t, estimate_run(t, f), processes) + processes * 2 * (int64_t)a->size;
  t->memory_estimate = r->memory_bytes / processes;
  const int64_t each = r->memory_bytes / processes;
  if (each <= t->limits->memory_bytes) return true;
  problem_begin(&p, 422,
                "the run needs about %lld bytes of memory%s, a worker may have %lld "
                "(memory-bytes)",
                (long long)each, processes > 1 ? " in each process" : "",
                (long long)t->limits->memory_bytes);
  problem_add(&p, "/inputs/cloud", "%lld points are too many for this process and operator",
              (long long)(t->cloud ? t->cloud->cloud.n : 0));
  refuse(r, &p);
  return false;
}

/* A form that needs the whole result goes by way of a stored one. */
static bool run_and_render(const ask *a, task *t, performance *f, reply *r) {
  emit *e = perform_run(t, f, PERFORM_STORED);
  size_t size = 0;
  void *bytes = e ? emit_take(e, &size) : NULL;
  emit_free(&e);
  bool done = bytes && render_stored(a, t, bytes, size, r);
  free(bytes);
  return done;
}

static bool is_plain(const execute *x, media form) {
  bool is_plain = !x->by_reference && (form == MEDIA_JSON || form == MEDIA_CBOR);
  for (int k = 0; k < PROCESS_OUTPUTS_MAX; k++) {
    media asked = x->format[k];
    is_plain = is_plain && (asked == MEDIA_COUNT || asked == MEDIA_JSON || asked == form);
  }
  return is_plain;
}

static bool do_run(const ask *a, task *t, performance *f, reply *r) {
  problem refusal;
  if (!fits_into_memory(a, t, f, r)) return false;
  execute_refuse_subscriber(t, &f->body, &f->wanted);
  if (!a->calls.keep) execute_refuse_references(t, f->process, &f->body, &f->wanted);
  if (!task_is_well(t)) return false;
  media form = render_form(f->process, &f->wanted, &a->accept, &refusal);
  if (form == MEDIA_COUNT) {
    refuse(r, &refusal);
    return false;
  }
  if (!is_plain(&f->wanted, form)) return run_and_render(a, t, f, r);
  emit *e = perform_run(t, f, form == MEDIA_CBOR ? PERFORM_CBOR : PERFORM_JSON);
  return pack_emit(a, t, e, form, r);
}

static bool do_run_stored(const ask *a, task *t, performance *f, reply *r) {
  if (!by_ranks_begin(t, f)) return true; /* without a reply */
  if (!fits_into_memory(a, t, f, r)) return false;
  return pack_emit(a, t, perform_run(t, f, PERFORM_STORED), MEDIA_CBOR, r);
}

static bool do_check(const ask *a, task *t, performance *f, reply *r) {
  grow_bytes frames = {0};
  if (!fits_into_memory(a, t, f, r) || !task_is_well(t)) return false;
  if (!grow_room(&frames, 1)) return out_of_memory(t); /* no frames are bytes, too */
  bool done = check_frames(t, f, &frames);
  if (!done) free(frames.data);
  if (!done) return false;
  r->status = 200;
  r->bytes = frames.data;
  r->size = frames.size;
  snprintf(r->type, sizeof r->type, "%s", media_type(MEDIA_OCTETS));
  return true;
}

static bool (*const works[])(const ask *, task *, performance *, reply *) = {
    [IPC_RUN] = do_run,
    [IPC_RUN_STORED] = do_run_stored,
    [IPC_CHECK] = do_check,
};

/* Reads a decoded request and does what is to be done with it. */
static void reply_to(const ask *a, const process *p, const doc *root, task *t, reply *r) {
  performance f;
  perform_read(t, p, root, &f);
  if (!works[a->work](a, t, &f, r) && !r->bytes) refuse_task(r, t);
  if (t->cloud) r->points = t->cloud->cloud.n;
  perform_clear(&f);
}

static void answer_request(const ask *a, task *t, reply *r) {
  const process *p = process_find(a->process);
  const doc *root = NULL;
  void *plain = NULL;
  size_t size = 0;
  if (!p) {
    problem missing;
    problem_begin_type(&missing, PROBLEM_NO_SUCH_PROCESS, 404, "there is no process \"%s\"",
                       a->process);
    refuse(r, &missing);
    return;
  }
  if (body_unpack(a, &plain, &size, r)) root = body_decode(a, plain ? plain : a->body, size, t, r);
  if (root) reply_to(a, p, root, t, r);
  free(plain);
}

/* A body to be kept: anything that can be read. RUN gives it back without its content coding. */
static void answer_data(const ask *a, task *t, reply *r) {
  void *plain = NULL;
  size_t size = 0;
  if (!body_unpack(a, &plain, &size, r)) return;
  if (body_decode(a, plain ? plain : a->body, size, t, r)) {
    size_t kept = a->work == IPC_RUN ? size : 0;
    r->bytes = malloc(kept + 1);
    if (r->bytes && kept) memcpy(r->bytes, plain ? plain : a->body, kept);
    r->size = kept;
    if (r->bytes) r->status = 200;
    snprintf(r->type, sizeof r->type, "%s", media_type(a->content));
  }
  free(plain);
}

static void answer_render(const ask *a, task *t, reply *r) {
  t->arena = doc_arena_new();
  if (!t->arena) (void)sct_fail(&t->error, SCT_E_MEMORY, -1, "no memory for the result");
  bool done = t->arena && render_stored(a, t, a->body, a->size, r);
  if (!done && !r->bytes) refuse_task(r, t);
}

void answer_prepare(void) {
  sct_solver_prepare();
}

void answer(const ask *a, reply *r) {
  if (a->work == IPC_RUN && um_bridge_is(a->process)) {
    um_bridge_answer(a, r);
    return;
  }
  by_href references = {.calls = &a->calls};
  progress whole = {.calls = &a->calls};
  task t = {.limits = a->limits,
            .by_href = &references,
            .work = {(int)a->limits->threads, progress_report, &whole, progress_residual},
            .checkpoint = a->checkpoint,
            .checkpoint_size = a->checkpoint_size,
            .ranks = a->ranks,
            .keep_checkpoint = a->calls.checkpoint};
  *r = (reply){.status = 500};
  stopwatch_start(&t.watch);
  report_begin();
  if (a->work == IPC_RENDER) {
    answer_render(a, &t, r);
  } else if (!strcmp(a->process, ANSWER_DATA)) {
    answer_data(a, &t, r);
  } else {
    answer_request(a, &t, r);
  }
  language_free(&t.language);
  doc_arena_free(&t.arena);
  by_href_clear(&references);
}
