#include "callback.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "base64.h"
#include "digest.h"
#include "gate.h"
#include "job_status.h"
#include "outbound.h"
#include "problem.h"
#include "store_shared.h"

enum { AT_ONCE = 8, REPLY_BYTES = 65536 };
static const double claim_seconds = 120; /* after which a call that a daemon took is due again */
static const double look_seconds = 5;    /* between looks for calls that another daemon left */
static const double call_seconds = 30;
static const double first_pause = 1, pause_factor = 4, longest_pause = 3600;
static const char *const members[] = {"successUri", "inProgressUri", "failedUri"};

typedef struct {
  callbacks *all;
  bool busy;
  job_call call;
  job_row row;
  job_extra extra;
  pool_task *task; /* rendering the results */
  int stored;      /* descriptor of them */
  void *body;      /* malloc'ed, or mapped if `mapped` */
  size_t size;
  bool mapped;
  outbound_call *out;
} calling;

struct callbacks {
  const service *service;
  bool looked; /* all that is due is being made */
  double due;  /* unix_now at which the next one is */
  calling slot[AT_ONCE];
};

bool callback_allows(const service *s, exchange *x, const job_extra *extra) {
  problem p;
  char pointer[64];
  problem_begin(&p, 400, "subscriber: an address is not allowed (callback-hosts)");
  for (int k = 0; k < 3; k++) {
    const char *uri = extra->uri[k];
    if (*uri == '\0' || outbound_allows(s->set->callback_hosts, uri)) continue;
    snprintf(pointer, sizeof pointer, "/subscriber/%s", members[k]);
    problem_add(&p, pointer,
                "got \"%.200s\", needs http:// or https:// and a host among \"%.200s\"", uri,
                s->set->callback_hosts);
  }
  if (p.count > 0) exchange_problem(x, &p);
  return p.count == 0;
}

/* ---- The end of a call ---- */

static void clear(calling *c) {
  if (c->task != NULL) pool_cancel(c->all->service->pool, c->task);
  if (c->out != NULL) outbound_cancel(c->out);
  if (c->stored >= 0) close(c->stored);
  if (c->mapped) {
    munmap(c->body, c->size);
  } else {
    free(c->body);
  }
  *c = (calling){.all = c->all, .stored = -1};
}

__attribute__((format(printf, 2, 3))) static void note(const calling *c, const char *format, ...) {
  char what[240], text[320];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(what, sizeof what, format, arguments);
  va_end(arguments);
  snprintf(text, sizeof text, "%s: attempt %d, %s", members[c->call.kind], c->call.attempts, what);
  (void)store_log(jobs_store(c->all->service->jobs), c->row.number, unix_now(), text);
}

static void look_again(callbacks *all) {
  all->looked = false;
  all->due = 0;
}

/* After the store was told of an end. Where it could not be, the same call is due again at once:
 * not without a pause, so that a subscriber does not suffer for our disk. */
static void look_after(callbacks *all, store_result told) {
  look_again(all);
  if (told == STORE_OK) return;
  all->looked = true;
  all->due = unix_now() + first_pause;
}

static void end_for_good(calling *c) {
  callbacks *all = c->all;
  const store_result told = store_remove_call(jobs_store(all->service->jobs), c->call.number);
  clear(c);
  look_after(all, told);
}

/* The call failed: it is due again after a pause, or never. */
static void end_for_now(calling *c, const char *why) {
  callbacks *all = c->all;
  const double pause = fmin(longest_pause, first_pause * pow(pause_factor, c->call.attempts - 1));
  if (c->call.attempts >= all->service->set->callback_attempts) {
    note(c, "%s; given up", why);
    end_for_good(c);
    return;
  }
  note(c, "%s; again in %.0f s", why, pause);
  c->call.due = unix_now() + pause;
  const store_result told = store_update_call(jobs_store(all->service->jobs), &c->call);
  clear(c);
  look_after(all, told);
}

static void answered(void *context, const outbound_reply *r) {
  calling *c = context;
  char why[240];
  c->out = NULL;
  if (r->fd >= 0) close(r->fd);
  if (r->status >= 200 && r->status < 300) {
    note(c, "answered %d", r->status);
    end_for_good(c);
    return;
  }
  if (r->status > 0) {
    snprintf(why, sizeof why, "answered %d", r->status);
  } else {
    snprintf(why, sizeof why, "%s", r->why);
  }
  end_for_now(c, why);
}

/* ---- The call ---- */

/* webhook-signature of the body; "" without a key. False when out of memory. */
static bool sign(const calling *c, const char *id, long long time, char field[160]) {
  const char *key = c->all->service->set->callback_key;
  unsigned char sum[DIGEST_BYTES];
  char head[160];
  size_t length = 0;
  *field = '\0';
  if (*key == '\0') return true;
  snprintf(head, sizeof head, "%s.%lld.", id, time);
  digest_sign(key, head, c->body, c->size, sum);
  char *text = base64_encode(sum, sizeof sum, &length);
  if (text == NULL) return false;
  snprintf(field, 160, "webhook-signature: v1,%s", text);
  free(text);
  return true;
}

static void send_call(calling *c) {
  char id[96], id_field[128], time_field[64], signature[160];
  const long long now = (long long)unix_now();
  snprintf(id, sizeof id, "%s-%s", c->row.id, members[c->call.kind]);
  snprintf(id_field, sizeof id_field, "webhook-id: %s", id);
  snprintf(time_field, sizeof time_field, "webhook-timestamp: %lld", now);
  if (!sign(c, id, now, signature)) {
    end_for_now(c, "out of memory");
    return;
  }
  const outbound_request r = {.url = c->extra.uri[c->call.kind],
                              .fields = {"Content-Type: application/json", id_field, time_field,
                                         *signature != '\0' ? signature : NULL},
                              .has_body = true,
                              .body = c->body,
                              .size = c->size,
                              .seconds = call_seconds,
                              .most = REPLY_BYTES};
  c->out = outbound_start(c->all->service->outbound, &r, answered, c);
  if (c->out == NULL) end_for_now(c, "out of memory");
}

static void rendered(void *context, const pool_outcome *o) {
  calling *c = context;
  c->task = NULL;
  const bool good = o->end == POOL_REPLY && o->status == 200;
  if (good && o->size > 0) {
    c->body = mmap(NULL, o->size, PROT_READ, MAP_PRIVATE, o->fd, 0);
    c->mapped = c->body != MAP_FAILED;
    c->size = o->size;
    if (!c->mapped) c->body = NULL;
  }
  if (o->fd >= 0) close(o->fd);
  if (good && (c->mapped || o->size == 0)) {
    send_call(c);
  } else {
    end_for_now(c, "the results cannot be rendered");
  }
}

/* A batch is told by its statusInfo: its results may be many documents. */
static void render(calling *c) {
  static const pool_calls calls = {rendered, NULL};
  const service *s = c->all->service;
  ipc_ask ask = {.work = IPC_RENDER,
                 .size = c->row.result_size,
                 .content = MEDIA_CBOR,
                 .content_coding = (coding)c->row.result_coding,
                 .accept = media_wish(MEDIA_JSON),
                 .limits = s->set->limits};
  gate_ask_again(s->gate, c->row.submitter, &ask);
  snprintf(ask.process, sizeof ask.process, "%s", c->row.process);
  snprintf(ask.results_url, sizeof ask.results_url, "%s/jobs/%s/results", c->extra.base, c->row.id);
  c->stored = jobs_result(s->jobs, &c->row);
  if (c->stored >= 0) c->task = pool_submit(s->pool, &ask, c->stored, &calls, c);
  if (c->task == NULL) end_for_now(c, "the results cannot be read now");
}

/* Counts the attempt; among several daemons it is made by the one that could count it. */
static bool claim(calling *c, store *s) {
  c->call.attempts++;
  if (!store_is_shared(s)) return true;
  c->call.due = unix_now() + claim_seconds;
  return store_claim_call(s, jobs_holder(c->all->service->jobs), &c->call) == STORE_OK;
}

static void begin(calling *c, const job_call *call) {
  store *s = jobs_store(c->all->service->jobs);
  c->busy = true;
  c->call = *call;
  if (!claim(c, s)) {
    clear(c);
    return;
  }
  store_result known = store_job_number(s, call->job, &c->row);
  if (known == STORE_OK) known = store_extra(s, call->job, &c->extra);
  if (known != STORE_OK && known != STORE_NONE) {
    end_for_now(c, "the store cannot be read now");
    return;
  }
  if (known == STORE_NONE || c->row.state == JOB_DISMISSED) {
    end_for_good(c); /* there is nothing to tell any more */
    return;
  }
  if (call->kind == 0 && c->row.parts == 0) {
    render(c);
    return;
  }
  const job_view view = jobs_view(c->all->service->jobs, &c->row);
  c->body = job_status_bytes(&view, c->extra.base, false, NULL, &c->size);
  if (c->body != NULL) {
    send_call(c);
  } else {
    end_for_now(c, "out of memory");
  }
}

/* ---- Which calls ---- */

typedef struct {
  int count;
  job_call call[2 * AT_ONCE];
} found;

static void note_found(void *context, const job_call *call) {
  found *f = context;
  f->call[f->count++] = *call;
}

static calling *slot_for(callbacks *all, const job_call *call) {
  calling *empty = NULL;
  for (int k = 0; k < AT_ONCE; k++) {
    calling *c = &all->slot[k];
    if (c->busy && c->call.number == call->number) return NULL; /* it is being made */
    if (!c->busy) empty = c;
  }
  return empty;
}

static void look(callbacks *all) {
  found f = {0};
  all->looked = true;
  const bool shared = store_is_shared(all->service->store);
  all->due = shared ? unix_now() + look_seconds : INFINITY;
  if (store_calls(jobs_store(all->service->jobs), 2 * AT_ONCE, note_found, &f) != STORE_OK) {
    all->due = unix_now() + first_pause;
    return;
  }
  const double now = unix_now();
  for (int k = 0; k < f.count; k++) {
    if (f.call[k].due > now) {
      all->due = fmin(all->due, f.call[k].due);
      continue;
    }
    calling *c = slot_for(all, &f.call[k]);
    if (c != NULL) begin(c, &f.call[k]);
  }
}

static double due(void *self) {
  const callbacks *all = self;
  if (!all->looked) return 0;
  return all->due < INFINITY ? loop_now() + (all->due - unix_now()) : INFINITY;
}

static void run(void *self) {
  look(self);
}

static void told(void *self) {
  look_again(self);
}

void callbacks_shift(callbacks *all, double by) {
  all->due += by;
}

callbacks *callbacks_new(loop *l, const service *s) {
  callbacks *all = calloc(1, sizeof *all);
  if (all == NULL) return NULL;
  all->service = s;
  for (int k = 0; k < AT_ONCE; k++) all->slot[k] = (calling){.all = all, .stored = -1};
  loop_add(l, (loop_chore){due, run, all});
  jobs_on_change(s->jobs, told, all);
  return all;
}

void callbacks_free(callbacks **all) {
  if (*all == NULL) return;
  jobs_on_change((*all)->service->jobs, NULL, NULL);
  for (int k = 0; k < AT_ONCE; k++) clear(&(*all)->slot[k]);
  free(*all);
  *all = NULL;
}
