#include "execute.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "gate.h"
#include "http.h"
#include "media.h"
#include "outcome.h"
#include "prefer.h"
#include "quota.h"
#include "site.h"
#include "submit.h"

typedef struct {
  const service *service;
  exchange *x;
  prefer prefer;
  ipc_ask ask;
  pool_task *task;        /* NULL: does not wait or run */
  submission *submission; /* NULL: is no job */
} execution;

/* ---- The header ---- */

static const char *const offers[] = {"application/json", "application/cbor"};
/* What some process may answer with; the worker knows which. */
static const media offered[] = {MEDIA_JSON, MEDIA_CBOR, MEDIA_NPY,
                                MEDIA_VTP,  MEDIA_CSV,  MEDIA_MULTIPART};

static const char *field(const exchange *x, const char *name, char room[512]) {
  return http_field(x, name, room, 512);
}

static void check_process(execution *e) {
  const char *id = e->x->item;
  problem p;
  snprintf(e->ask.process, sizeof e->ask.process, "%.63s", id);
  if (site_has_process(id)) return;
  problem_begin_type(&p, PROBLEM_NO_SUCH_PROCESS, 404, "there is no process \"%.100s\"", id);
  exchange_problem(e->x, &p);
}

static void check_content(execution *e) {
  char room[512];
  const char *text = field(e->x, "Content-Type", room);
  if (!e->x->has_body) {
    exchange_refuse(e->x, 411, "body: got neither Content-Length nor Transfer-Encoding");
  } else if (!media_of_body(text, &e->ask.content) || e->ask.content > MEDIA_CBOR) {
    exchange_add(e->x, "Accept", "%s, %s", offers[0], offers[1]);
    exchange_refuse(e->x, 415, "Content-Type: got \"%.100s\", needs %s (UTF-8) or %s", text,
                    offers[0], offers[1]);
  }
}

static void check_content_coding(execution *e) {
  char room[512];
  const char *text = field(e->x, "Content-Encoding", room);
  if (coding_of_body(text, &e->ask.content_coding)) return;
  exchange_add(e->x, "Accept-Encoding", "gzip, zstd");
  exchange_refuse(e->x, 415, "Content-Encoding: got \"%.100s\", needs one of gzip, zstd, identity",
                  text);
}

static void check_accept(execution *e) {
  char room[512];
  const char *text = field(e->x, "Accept", room);
  e->ask.accept = media_wishes(text);
  if (media_pick(&e->ask.accept, offered, sizeof offered / sizeof *offered) != MEDIA_COUNT) return;
  exchange_refuse(e->x, 406, "Accept: got \"%.100s\", needs %s or %s among it", text, offers[0],
                  offers[1]);
}

static void check_accept_coding(execution *e) {
  char room[512];
  const char *text = field(e->x, "Accept-Encoding", room);
  if (coding_choose(text, &e->ask.accept_coding)) return;
  exchange_refuse(e->x, 406, "Accept-Encoding: got \"%.100s\", needs gzip, zstd or identity", text);
}

static void (*const checks[])(execution *) = {check_process, check_content, check_content_coding,
                                              check_accept, check_accept_coding};

void execute_begin(const service *s, exchange *x) {
  char room[512];
  execution *e = x->task = calloc(1, sizeof *e);
  if (e == NULL) {
    exchange_refuse(x, 503, "out of memory");
    return;
  }
  e->service = s;
  e->x = x;
  gate_ask(s->gate, x, &e->ask);
  e->prefer = prefer_of(field(x, "Prefer", room), s->set->wait_seconds);
  for (size_t k = 0; k < sizeof checks / sizeof *checks && x->reply.status == 0; k++) checks[k](e);
}

/* ---- The reply ---- */

static void done(void *context, const pool_outcome *outcome) {
  execution *e = context;
  e->task = NULL;
  outcome_reply(e->x, &e->ask.limits, outcome);
  http_deliver(e->x);
}

/* A batch is a job in any case. */
static bool becomes_job(const execution *e) {
  return e->prefer.respond_async || strcmp(e->ask.process, "batch") == 0;
}

void execute_serve(const service *s, exchange *x) {
  static const pool_calls calls = {done, NULL};
  execution *e = x->task;
  e->ask.size = x->body.size;
  snprintf(e->ask.base, sizeof e->ask.base, "%s", x->base);
  snprintf(x->process, sizeof x->process, "%s", x->item);
  if (becomes_job(e)) {
    e->submission = submit_new(s, x, &e->prefer, &e->ask);
    return;
  }
  if (!quota_allows(s, x, 1)) return;
  e->task = pool_submit(s->pool, &e->ask, x->body.fd, &calls, e);
  if (e->task == NULL) outcome_refuse_full(x, s->pool, s->set->queue);
}

void execute_end(const service *s, exchange *x) {
  execution *e = x->task;
  if (e == NULL) return;
  if (e->task != NULL) pool_cancel(s->pool, e->task);
  submit_free(&e->submission);
  free(e);
  x->task = NULL;
}
