#include "execute.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "http.h"
#include "media.h"
#include "prefer.h"
#include "site.h"

typedef struct {
  const service *service;
  exchange *x;
  prefer prefer; /* respond-async will choose a job here; until there are jobs all is synchronous */
  ipc_ask ask;
  pool_task *task; /* NULL: does not wait or run */
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
  snprintf(e->ask.process, sizeof e->ask.process, "%s", id);
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
  e->ask.limits = s->set->limits;
  e->prefer = prefer_of(field(x, "Prefer", room));
  for (size_t k = 0; k < sizeof checks / sizeof *checks && x->reply.status == 0; k++) checks[k](e);
}

/* ---- The reply ---- */

static void reply_worker(execution *e, const pool_outcome *o) {
  const bool refused = strcmp(o->type, media_type(MEDIA_PROBLEM)) == 0;
  const char *type = refused && e->x->plain_problem ? media_type(MEDIA_JSON) : o->type;
  exchange_file(e->x, o->status, type, o->coding, o->fd, o->size);
}

/* " in phase factor", or nothing when the worker never told. */
static const char *where(const pool_outcome *o, char room[64]) {
  snprintf(room, 64, *o->phase != '\0' ? " in phase %s" : "", o->phase);
  return room;
}

static void reply_memory(execution *e, const pool_outcome *o) {
  char room[64];
  exchange_refuse(e->x, 422, "the solve%s needs more than %lld bytes of memory (memory-bytes)",
                  where(o, room), (long long)e->ask.limits.memory_bytes);
}

static void reply_time(execution *e, const pool_outcome *o) {
  char room[64];
  exchange_refuse(e->x, 504, "the solve was stopped%s after %g s (limit: seconds)", where(o, room),
                  e->ask.limits.seconds);
}

static void reply_crash(execution *e, const pool_outcome *o) {
  char room[64];
  exchange_refuse(e->x, 500, "the worker died%s; the log knows more under request %s",
                  where(o, room), e->x->id);
}

static void reply_stopped(execution *e, const pool_outcome *o) {
  (void)o;
  exchange_add(e->x, "Retry-After", "%d", 10);
  exchange_refuse(e->x, 503, "the service is being stopped");
}

static void (*const replies[])(execution *, const pool_outcome *) = {
    [POOL_REPLY] = reply_worker, [POOL_MEMORY] = reply_memory,   [POOL_TIME] = reply_time,
    [POOL_CRASH] = reply_crash,  [POOL_STOPPED] = reply_stopped,
};

static void done(void *context, const pool_outcome *outcome) {
  execution *e = context;
  e->task = NULL;
  e->x->worker = outcome->worker;
  e->x->run_seconds = outcome->seconds;
  e->x->points = outcome->points;
  replies[outcome->end](e, outcome);
  http_deliver(e->x);
}

void execute_serve(const service *s, exchange *x) {
  execution *e = x->task;
  e->ask.size = x->body.size;
  snprintf(x->process, sizeof x->process, "%s", x->item);
  e->task = pool_submit(s->pool, &e->ask, x->body.fd, done, e);
  if (e->task != NULL) return;
  exchange_add(x, "Retry-After", "%d", pool_retry_after(s->pool));
  exchange_refuse(x, 503, "all workers are busy and %lld requests wait (limit: queue)",
                  (long long)s->set->queue);
}

void execute_end(const service *s, exchange *x) {
  execution *e = x->task;
  if (e != NULL && e->task != NULL) pool_cancel(s->pool, e->task);
  free(e);
  x->task = NULL;
}
