#include "bridge.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "gate.h"
#include "http.h"
#include "media.h"
#include "outcome.h"
#include "quota.h"

typedef struct {
  exchange *x;
  ipc_ask ask;
  pool_task *task; /* NULL: does not wait or run */
} crossing;

void bridge_info(const service *s, exchange *x) {
  (void)s;
  exchange_text(x, 200, media_type(MEDIA_JSON), "{\"protocolVersion\":1.0,\"models\":[\"solve\"]}");
}

/* ---- Outcomes ---- */

static void reply_worker(crossing *c, const pool_outcome *o) {
  exchange_file(c->x, o->status, o->type, o->coding, o->fd, o->size);
}

static void reply_memory(crossing *c, const pool_outcome *o) {
  (void)o;
  exchange_refuse(c->x, 500, "the model needs more than %lld bytes of memory (memory-bytes)",
                  (long long)c->ask.limits.memory_bytes);
}

static void reply_time(crossing *c, const pool_outcome *o) {
  (void)o;
  exchange_refuse(c->x, 500, "the model was stopped after %g s (limit: seconds)",
                  c->ask.limits.seconds);
}

static void reply_crash(crossing *c, const pool_outcome *o) {
  (void)o;
  exchange_refuse(c->x, 500, "the worker died; the log knows more under request %s", c->x->id);
}

static void reply_stopped(crossing *c, const pool_outcome *o) {
  (void)o;
  exchange_add(c->x, "Retry-After", "%d", 10);
  exchange_refuse(c->x, 503, "the service is being stopped");
}

static void (*const replies[])(crossing *, const pool_outcome *) = {
    [POOL_REPLY] = reply_worker, [POOL_MEMORY] = reply_memory,   [POOL_TIME] = reply_time,
    [POOL_CRASH] = reply_crash,  [POOL_STOPPED] = reply_stopped,
};

/* ---- A request ---- */

void bridge_begin(const service *s, exchange *x) {
  crossing *c = x->task = calloc(1, sizeof *c);
  if (c == NULL) {
    exchange_refuse(x, 503, "out of memory");
    return;
  }
  c->x = x;
  c->ask = (ipc_ask){.content = MEDIA_JSON};
  gate_ask(s->gate, x, &c->ask);
  snprintf(c->ask.process, sizeof c->ask.process, "um-bridge%.40s", x->path);
}

static void done(void *context, const pool_outcome *outcome) {
  crossing *c = context;
  c->task = NULL;
  c->x->worker = outcome->worker;
  c->x->run_seconds = outcome->seconds;
  c->x->points = outcome->points;
  replies[outcome->end](c, outcome);
  http_deliver(c->x);
}

void bridge_serve(const service *s, exchange *x) {
  static const pool_calls calls = {done, NULL};
  crossing *c = x->task;
  c->ask.size = x->body.size;
  snprintf(x->process, sizeof x->process, "%.60s", c->ask.process);
  if (!quota_allows(s, x, 1)) return;
  c->task = pool_submit(s->pool, &c->ask, x->body.fd, &calls, c);
  if (c->task != NULL) return;
  outcome_refuse_full(x, s->pool, s->set->queue);
}

void bridge_end(const service *s, exchange *x) {
  crossing *c = x->task;
  if (c != NULL && c->task != NULL) pool_cancel(s->pool, c->task);
  free(c);
  x->task = NULL;
}
