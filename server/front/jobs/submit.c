#include "submit.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "callback.h"
#include "digest.h"
#include "frames.h"
#include "http.h"
#include "job_queue.h"
#include "job_status.h"
#include "outcome.h"
#include "quota.h"
#include "rendering.h"
#include "submitter.h"

/* The digest of a body, being taken. */
typedef struct {
  submission *wanted; /* NULL: its exchange has ended */
  char label[128];
  int fd; /* the body's, given back */
  size_t size;
  char digest[DIGEST_TEXT];
  bool good;
  clerk *clerk;
  clerk_task task;
} reading;

struct submission {
  const service *service;
  exchange *x;
  prefer prefer;
  ipc_ask ask;
  job_extra extra;
  reading *reading;     /* first */
  bool sleeps;          /* its connection: a reply must be delivered */
  pool_task *task;      /* the check */
  bool holds;           /* a place in the queue, during the check */
  wait wait;            /* for the end, with Prefer: wait */
  rendering *rendering; /* of the results, after it */
};

static void refuse_memory(exchange *x) {
  exchange_refuse(x, 503, "out of memory");
}

/* ---- The reply ---- */

static void add_applied(submission *b, bool waited) {
  char text[128];
  int used = snprintf(text, sizeof text, "respond-async");
  const prefer *p = &b->prefer;
  if (!p->respond_async) return;
  if (waited) used += snprintf(text + used, sizeof text - (size_t)used, ", wait=%.0f", p->wait);
  if (p->shape != PREFER_ANY) {
    used += snprintf(text + used, sizeof text - (size_t)used, ", return=%s",
                     p->shape == PREFER_MINIMAL ? "minimal" : "representation");
  }
  if (p->priority >= 0) {
    snprintf(text + used, sizeof text - (size_t)used, ", priority=%d", p->priority);
  }
  exchange_add(b->x, "Preference-Applied", "%s", text);
}

/* 201, Location and statusInfo. */
static void reply_created(submission *b, const job_view *view, bool waited) {
  add_applied(b, waited);
  exchange_add(b->x, "Location", "%s/jobs/%s", b->x->base, view->row.id);
  job_status_reply(b->x, 201, view, b->prefer.shape == PREFER_MINIMAL,
                   jobs_store(b->service->jobs));
}

static void deliver_created(submission *b, const job_view *view, bool waited) {
  reply_created(b, view, waited);
  http_deliver(b->x);
}

/* The job was over before the wait was: what a synchronous execution would reply. */
static void reply_results(submission *b, const job_row *row) {
  exchange *x = b->x;
  exchange_add(x, "Preference-Applied", "wait=%.0f", b->prefer.wait);
  exchange_add(x, "Content-Location", "%s/jobs/%s/results", x->base, row->id);
  if (row->state == JOB_SUCCESSFUL && row->parts == 0) {
    b->rendering = rendering_new(b->service, x, row, "");
    if (b->rendering != NULL) return; /* it delivers */
  } else {
    job_refuse_failed(x, b->service->jobs, row);
  }
  http_deliver(x);
}

static bool is_over(void *self, const job_view *now) {
  (void)self;
  return job_state_is_final((job_state)now->row.state);
}

static void waited(void *self, const job_view *now) {
  submission *b = self;
  const bool results = (now->row.state == JOB_SUCCESSFUL || now->row.state == JOB_FAILED) &&
                       b->prefer.shape != PREFER_MINIMAL && now->row.parts == 0;
  if (results) {
    reply_results(b, &now->row);
  } else {
    deliver_created(b, now, true);
  }
}

static bool check_key(submission *b);

/* By way of another daemon a request with the same key, or of the same owner, may have been a
 * moment faster. */
static void refuse_stored(submission *b, store_result result) {
  if (result == STORE_TAKEN && !check_key(b)) return;
  if (result == STORE_LIMIT) {
    quota_refuse_late(b->service, b->x);
  } else {
    job_refuse_store(b->x, result);
  }
}

static void stored(void *self, const job_row *row, store_result result) {
  submission *b = self;
  job_view view;
  if (result != STORE_OK) {
    refuse_stored(b, result);
    http_deliver(b->x);
    return;
  }
  view = jobs_view(b->service->jobs, row);
  if (b->prefer.wait <= 0 || !b->prefer.respond_async) {
    deliver_created(b, &view, false);
    return;
  }
  b->wait.now = view;
  if (view.active == NULL) {
    waited(b, &view);
  } else {
    wait_on(b->service->waits, &b->wait, b->prefer.wait);
  }
}

/* ---- Retries ---- */

/* An Idempotency-Key that is known has its job already. False when a reply is set. */
static bool check_key(submission *b) {
  exchange *x = b->x;
  char room[512], submitter[JOB_SUBMITTER], digest[JOB_DIGEST];
  job_row row;
  const char *key = http_field(x, "Idempotency-Key", room, sizeof room);
  if (key == NULL) return true;
  if (*key == '\0' || strlen(key) >= JOB_KEY) {
    exchange_refuse(x, 400, "Idempotency-Key: got %zu characters, needs 1 to %d", strlen(key),
                    JOB_KEY - 1);
    return false;
  }
  snprintf(b->extra.key, sizeof b->extra.key, "%s", key);
  submitter_of(x, submitter);
  if (store_by_key(jobs_store(b->service->jobs), submitter, key, &row, digest) != STORE_OK) {
    return true;
  }
  if (strcmp(digest, b->extra.digest) == 0) {
    const job_view view = jobs_view(b->service->jobs, &row);
    reply_created(b, &view, false);
  } else {
    exchange_refuse(x, 422, "Idempotency-Key: got \"%.100s\", which another request has", key);
  }
  return false;
}

/* ---- The order ---- */

static void refuse_large(exchange *x, int64_t bytes, int64_t most) {
  exchange_refuse(x, 422,
                  "memory: the request is estimated to need %lld bytes, may need at most %lld "
                  "(memory-bytes, memory-budget)",
                  (long long)bytes, (long long)most);
}

/* Does each of them fit into the memory of where it will run? */
static bool fit_into_memory(submission *b, const job_part *parts, int64_t count) {
  for (int64_t k = 0; k < count; k++) {
    const int64_t most = jobs_most_memory_of(b->service->jobs, parts[k].process, parts[k].points);
    if (parts[k].estimate <= most) continue;
    refuse_large(b->x, parts[k].estimate, most);
    return false;
  }
  return true;
}

static bool fits(submission *b, const frames *f, const pool_outcome *o) {
  const jobs *j = b->service->jobs;
  const int64_t parts = f->count > 0 ? f->count : 1;
  job_part whole = {.points = o->points, .estimate = o->memory_bytes};
  snprintf(whole.process, sizeof whole.process, "%s", b->ask.process);
  if (!fit_into_memory(b, f->count > 0 ? f->parts : &whole, parts)) return false;
  if (f->count > b->service->set->batch_parts || parts > b->service->set->job_queue) {
    exchange_refuse(b->x, 422,
                    "batch: got %d requests, needs at most %lld (batch-parts, job-queue)", f->count,
                    (long long)b->service->set->batch_parts);
  } else if (jobs_room(j) < parts) {
    exchange_add(b->x, "Retry-After", "%d", jobs_retry_after(j));
    exchange_refuse(b->x, 429, "%lld jobs wait already (limit: job-queue)",
                    (long long)(b->service->set->job_queue - jobs_room(j)));
  } else {
    return quota_allows(b->service, b->x, parts);
  }
  return false;
}

/* Does an equal request have an answer that may be given again? */
static bool find_answer(const submission *b, const job_order *o, job_row *other) {
  const service *s = b->service;
  char room[512];
  const char *cache = http_field(b->x, "Cache-Control", room, sizeof room);
  if (s->set->reuse_results == 0 || !o->row.reusable) return false;
  if (cache != NULL && strstr(cache, "no-cache") != NULL) return false;
  const double until = unix_now() + s->set->result_seconds / 2;
  return store_by_digest(jobs_store(s->jobs), b->x->owner, b->extra.digest, until, other) ==
         STORE_OK;
}

/* Processes whose answers depend on more than the request: on time. */
static bool is_pure(const char *process) {
  static const char *const timed[] = {"echo", "study", "batch"};
  for (size_t k = 0; k < sizeof timed / sizeof *timed; k++) {
    if (strcmp(process, timed[k]) == 0) return false;
  }
  return true;
}

static job_order order_of(submission *b, const frames *f, const pool_outcome *o) {
  exchange *x = b->x;
  job_order order = {
      .extra = &b->extra, .body = -1, .parts = f->parts, .stored = stored, .self = b};
  job_row *row = &order.row;
  snprintf(row->process, sizeof row->process, "%s", b->ask.process);
  submitter_of(x, row->submitter);
  row->priority = b->prefer.priority >= 0 ? b->prefer.priority : JOB_PRIORITY;
  row->content = (int)b->ask.content;
  row->content_coding = (int)b->ask.content_coding;
  row->size = x->body.size;
  row->points = o->points;
  row->estimate = o->memory_bytes;
  row->parts = f->count;
  row->reusable = is_pure(row->process) && !f->external;
  snprintf(b->extra.base, sizeof b->extra.base, "%s", x->base);
  b->extra.jobs_most = quota_jobs(b->service, x);
  if (f->count > 0) row->size = (int64_t)o->size; /* the frames hold the requests of the parts */
  return order;
}

static int take(int *fd) {
  const int taken = *fd;
  *fd = -1;
  return taken;
}

static store_result place(submission *b, const frames *f, pool_outcome *o) {
  job_order order = order_of(b, f, o);
  job_row other;
  if (find_answer(b, &order, &other) &&
      jobs_add_answered(b->service->jobs, &order, &other) == STORE_OK) {
    return STORE_OK;
  }
  order.body = f->count > 0 ? take(&o->fd) : spool_take(&b->x->body);
  return jobs_add(b->service->jobs, &order);
}

/* The request is good: it becomes a job, and o->fd -1 if that needs it. False when a reply is set,
 * also by an equal request that came first. */
static bool accept_frames(submission *b, pool_outcome *o) {
  frames f;
  bool good = false;
  const bool is_read = frames_read(o->fd, o->size, &f, b->extra.uri);
  memcpy(b->extra.pin, f.pin, sizeof f.pin);
  if (!is_read) {
    exchange_refuse(b->x, 500, "the worker's check cannot be read");
  } else if (check_key(b) && fits(b, &f, o) && callback_allows(b->service, b->x, &b->extra)) {
    const store_result result = place(b, &f, o);
    good = result == STORE_OK;
    if (!good) job_refuse_store(b->x, result);
  }
  frames_free(&f);
  return good;
}

static void give_back(submission *b) {
  if (b->holds) jobs_hold(b->service->jobs, -1);
  b->holds = false;
}

static void checked(void *context, const pool_outcome *o) {
  submission *b = context;
  b->task = NULL;
  give_back(b);
  if (o->end != POOL_REPLY || o->status != 200) {
    outcome_reply(b->x, &b->ask.limits, o);
    http_deliver(b->x);
    return;
  }
  b->x->points = o->points;
  pool_outcome mine = *o;
  const bool good = accept_frames(b, &mine);
  if (mine.fd >= 0) close(mine.fd);
  if (!good) http_deliver(b->x);
}

/* ---- The request ---- */

/* The place is held from now on: who finds none is told so at once, not after its check. */
static bool has_room(submission *b) {
  b->holds = jobs_room(b->service->jobs) > 0;
  if (b->holds) jobs_hold(b->service->jobs, 1);
  if (b->holds) return true;
  exchange_add(b->x, "Retry-After", "%d", jobs_retry_after(b->service->jobs));
  exchange_refuse(b->x, 429, "%lld jobs wait already (limit: job-queue)",
                  (long long)b->service->set->job_queue);
  return false;
}

static void ask_check(submission *b) {
  static const pool_calls calls = {checked, NULL};
  b->ask.work = IPC_CHECK;
  b->ask.size = b->x->body.size;
  b->task = pool_submit(b->service->pool, &b->ask, b->x->body.fd, &calls, b);
  if (b->task == NULL) outcome_refuse_full(b->x, b->service->pool, b->service->set->queue);
}

/* In the thread, if it is large. */
static void take_digest(void *self) {
  reading *r = self;
  r->good = digest_file(r->label, r->fd, r->size, r->digest);
}

/* What comes before the check. */
static void digested(void *self) {
  reading *r = self;
  submission *b = r->wanted;
  if (b == NULL) {
    clerk_close(r->clerk, r->fd);
    free(r);
    return;
  }
  b->reading = NULL;
  b->x->body.fd = r->fd;
  memcpy(b->extra.digest, r->digest, sizeof r->digest);
  if (!r->good) exchange_refuse(b->x, 500, "body: it cannot be read again");
  if (r->good && check_key(b) && has_room(b) && quota_allows(b->service, b->x, 1)) ask_check(b);
  free(r);
  if (b->x->reply.status != 0 && b->sleeps) http_deliver(b->x);
}

static void read_body(submission *b) {
  spool *body = &b->x->body;
  reading *r = b->reading = calloc(1, sizeof *r);
  if (r == NULL) {
    refuse_memory(b->x);
    return;
  }
  *r = (reading){
      .wanted = b, .size = (size_t)body->size, .fd = spool_take(body), .clerk = b->service->clerk};
  r->task = (clerk_task){take_digest, digested, r, NULL};
  snprintf(r->label, sizeof r->label, "%s %d %d", b->ask.process, (int)b->ask.content,
           (int)b->ask.content_coding);
  clerk_do(r->clerk, &r->task, body->size);
  b->sleeps = true;
}

static void forget(submission *b) {
  reading *r = b->reading;
  if (r == NULL) return;
  r->wanted = NULL;
  if (clerk_take_back(r->clerk, &r->task)) digested(r);
}

submission *submit_new(const service *s, exchange *x, const prefer *p, const ipc_ask *ask) {
  submission *b = calloc(1, sizeof *b);
  if (b == NULL) {
    refuse_memory(x);
    return NULL;
  }
  *b = (submission){.service = s, .x = x, .prefer = *p, .ask = *ask};
  b->wait.enough = is_over;
  b->wait.over = waited;
  b->wait.self = b;
  read_body(b);
  if (x->reply.status == 0) return b;
  submit_free(&b);
  return NULL;
}

void submit_free(submission **b) {
  if (*b == NULL) return;
  forget(*b);
  if ((*b)->task != NULL) pool_cancel((*b)->service->pool, (*b)->task);
  give_back(*b);
  jobs_forget((*b)->service->jobs, *b);
  wait_off(&(*b)->wait);
  rendering_free(&(*b)->rendering);
  free(*b);
  *b = NULL;
}
