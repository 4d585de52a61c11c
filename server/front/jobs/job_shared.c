#include "job_shared_inner.h"

#include <math.h>
#include <search.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/random.h>

#include "log.h"
#include "store_shared.h"

enum { NOTICE = 7800 /* a NOTIFY takes 8000 bytes */, ADOPTED = 64, QUEUE = 16 };

static const double tick_seconds = 1;    /* between looks at what is ours and watched */
static const double retry_seconds = 0.1; /* while there is no connection */
static const double count_seconds = 0.1; /* between counts of what waits while that is too much */
static const double old_seconds = 60; /* a job that waits longer is taken even if it needs to wait
                                       * for memory here */
static const double beats = 5, burials = 3; /* per lease */

/* ---- Storing ---- */

void job_shared_mark(job *c) {
  const bool is_ours = c->task != NULL || c->run != NULL || c->ends || c->node.waits;
  snprintf(c->row.holder, sizeof c->row.holder, "%s", is_ours ? c->all->shared->id : "");
}

typedef struct {
  size_t used;
  char text[NOTICE];
} notice;

static store_result send_notice(job_shared *h, notice *n) {
  if (n->used == 0) return STORE_OK;
  n->used = 0;
  return store_tell(h->all->store, n->text);
}

static store_result add_notice(job_shared *h, notice *n, const char *word) {
  const bool fits = n->used + strlen(word) + 2 < sizeof n->text;
  const store_result result = fits ? STORE_OK : send_notice(h, n);
  n->used += (size_t)snprintf(n->text + n->used, sizeof n->text - n->used, "%s ", word);
  return result;
}

store_result job_shared_tell(job_shared *h, const job *first) {
  notice n = {0};
  bool more = false, all_run = true;
  store_result result = STORE_OK;
  for (const job *c = first; c != NULL && result == STORE_OK; c = c->next_changed) {
    more |= c->row.state == JOB_ACCEPTED && *c->row.holder == '\0';
    all_run &= c->row.state == JOB_RUNNING;
    result = add_notice(h, &n, c->row.id);
    if (result == STORE_OK && c->batch != NULL) result = add_notice(h, &n, c->batch->row.id);
  }
  if (more && result == STORE_OK) result = add_notice(h, &n, "+");
  if (all_run && result == STORE_OK) result = store_relax(h->all->store); /* at worst run twice */
  return result == STORE_OK ? send_notice(h, &n) : result;
}

bool job_shared_may_add(const job *c) {
  const int64_t others = store_active_of(c->all->store, c->row.submitter);
  return others + job_places(c) <= c->extra->jobs_most;
}

void job_shared_settle(job *c) {
  job *batch = c->batch;
  if (batch != NULL && batch->elsewhere && batch->watches != NULL) job_read_again(batch);
  if (*c->row.holder != '\0') return;
  if (c->row.state == JOB_ACCEPTED) job_shared_more(c->all->shared, 0);
  job_put_elsewhere(c);
  job_drop_unneeded(c);
}

void job_shared_release(job *c) {
  jobs *j = c->all;
  job_shared_more(j->shared, c->row.state != JOB_ACCEPTED ? 0
                             : c->row.parts > 0           ? c->row.parts
                                                          : 1);
  while (c->parts != NULL) {
    job *part = c->parts;
    c->parts = part->sibling;
    job_free(part);
  }
  if (!job_row_is_over(&c->row)) job_put_elsewhere(c);
}

/* ---- Queue ---- */

static void count(job_shared *h) {
  const int64_t waiting = store_waiting(h->all->store);
  if (waiting >= 0) h->waiting = waiting;
  h->counted = loop_now();
}

/* Before somebody is refused it is counted again. */
int64_t job_shared_waiting(job_shared *h) {
  const int64_t own = (int64_t)job_queue_length(h->all->queue);
  const bool is_full = h->waiting + own >= h->all->set->job_queue;
  if (is_full && loop_now() > h->counted + count_seconds) count(h);
  return h->waiting + own;
}

void job_shared_more(job_shared *h, int64_t count) {
  h->more = true;
  h->waiting += count;
}

/* Only what a worker could begin with now, as far as one knows before; a few that do not fit may
 * wait here, where others pass them for a while (job_queue.h). */
static bool may_take(const job_shared *h) {
  const jobs *j = h->all;
  return h->more && j->pause == INFINITY && pool_has_room(j->pool) &&
         job_queue_length(j->queue) < QUEUE;
}

bool job_shared_take(job_shared *h) {
  jobs *j = h->all;
  job_row row;
  const int64_t room = j->counts.running == 0 ? INT64_MAX : j->budget - j->counts.memory;
  if (!may_take(h)) return false;
  const store_result result = store_take(j->store, h->id, room, unix_now() - old_seconds, &row);
  h->more = result == STORE_OK; /* what failed is tried again with the next tick */
  if (result != STORE_OK) return false;
  if (h->waiting > 0) h->waiting--;
  job *c = job_take_up(h, &row);
  if (c != NULL) job_enqueue(c, false);
  return c != NULL;
}

/* ---- What is ours ---- */

typedef struct {
  int count;
  job_row row[ADOPTED];
} rows;

typedef struct {
  job_shared *h;
  rows *strange; /* ours, but not in memory */
} look;

static bool note_held(void *context, const job_row *row) {
  look *l = context;
  job *c = job_find(l->h->all, row->id);
  if (c != NULL && !c->elsewhere) {
    c->round = l->h->round;
  } else if (l->strange->count < ADOPTED) {
    l->strange->row[l->strange->count++] = *row;
  }
  return true;
}

/* A job that a dead daemon had, or that this one took without hearing so. */
static void adopt(job_shared *h, const job_row *row) {
  job *c = job_take_up(h, row);
  if (c == NULL) return;
  if (row->parts > 0) {
    job_give_back(c);
  } else if (row->state == JOB_ACCEPTED) {
    job_enqueue(c, false);
  } else {
    job_wait_again(c);
  }
}

/* ---- All that are in memory ---- */

typedef struct {
  job **job;
  size_t count, room;
} list;

static void note_job(const void *node, VISIT when, void *context) {
  list *l = context;
  if (when != postorder && when != leaf) return;
  if (l->count == l->room) {
    const size_t room = l->room > 0 ? 2 * l->room : 64;
    job **more = realloc(l->job, room * sizeof *more);
    if (more == NULL) return; /* the others with the next tick */
    l->job = more;
    l->room = room;
  }
  l->job[l->count++] = *(job *const *)node;
}

/* One that was not among what the store says is ours. */
static bool is_lost(const job_shared *h, const job *c) {
  return !c->elsewhere && !c->changed && c->row.number > 0 && c->round != h->round;
}

/* Something to tell that the others have not been told. */
static bool has_progress(const job *c) {
  return !c->elsewhere && !c->changed && c->row.state == JOB_RUNNING &&
         (c->task != NULL || c->run != NULL) &&
         (c->told_progress != c->row.progress || c->told_residual != c->row.residual ||
          strcmp(c->told_phase, c->row.phase) != 0);
}

static bool tell_progress(job *c) {
  c->told_progress = c->row.progress;
  c->told_residual = c->row.residual;
  memcpy(c->told_phase, c->row.phase, sizeof c->told_phase);
  return store_progress(c->all->store, &c->row) == STORE_OK;
}

/* Jobs are found by id again: telling of one may end another. */
static void look_at_memory(job_shared *h) {
  list l = {0};
  notice n = {0};
  jobs *j = h->all;
  twalk_r(j->by_id, note_job, &l);
  char(*id)[JOB_ID] = calloc(l.count + 1, sizeof *id);
  for (size_t k = 0; id != NULL && k < l.count; k++) memcpy(id[k], l.job[k]->row.id, JOB_ID);
  for (size_t k = 0; id != NULL && k < l.count && store_is_up(j->store); k++) {
    job *c = job_find(j, id[k]);
    if (c == NULL) continue;
    if (!job_is_needed(c)) {
      job_free(c);
    } else if (is_lost(h, c)) {
      job_shared_lose(c);
    } else if (c->elsewhere && c->watches != NULL) {
      job_read_again(c);
    } else if (has_progress(c) && tell_progress(c)) {
      (void)add_notice(h, &n, c->row.id);
      if (c->batch != NULL) (void)add_notice(h, &n, c->batch->row.id);
    }
  }
  (void)send_notice(h, &n);
  free(id);
  free(l.job);
}

static void look_at_held(job_shared *h) {
  look l = {h, calloc(1, sizeof(rows))};
  if (l.strange == NULL) return;
  h->round++;
  if (store_held(h->all->store, h->id, note_held, &l) == STORE_OK) {
    for (int k = 0; k < l.strange->count; k++) adopt(h, &l.strange->row[k]);
    look_at_memory(h);
  }
  free(l.strange);
}

/* ---- Living ---- */

/* The database's clock has moved by more than ours since the last beat: what the others beat does
 * not count until they have beaten again. */
static void note_step(job_shared *h, double by) {
  const double lease = h->all->set->lease_seconds;
  if (fabs(by) < lease / beats) return;
  h->burial = loop_now() + lease;
  log_say(LOG_INFO, "clock", "the database's clock was set by %.0f s, or this machine slept", by);
}

static void beat(job_shared *h) {
  double now = 0;
  const double before = unix_now();
  if (loop_now() < h->beat || store_beat(h->all->store, h->id, &now) != STORE_OK) return;
  h->beat = loop_now() + h->all->set->lease_seconds / beats;
  note_step(h, unix_tune(now, before));
}

/* With a fresh beat, which knows of a step of the clock. */
static void bury(job_shared *h) {
  const double lease = h->all->set->lease_seconds;
  if (loop_now() < h->burial) return;
  h->beat = 0;
  beat(h);
  if (h->beat <= 0 || loop_now() < h->burial) return;
  h->burial = loop_now() + lease / burials;
  (void)store_bury(h->all->store, h->id, lease);
}

static bool note_done(void *context, const job_row *row) {
  rows *r = context;
  r->row[r->count++] = *row;
  return r->count < ADOPTED;
}

/* A batch whose last part ended with its daemon, or while another one had the batch. */
static void look_for_done_batches(job_shared *h) {
  rows *r = calloc(1, sizeof *r);
  if (r == NULL) return;
  (void)store_done_batches(h->all->store, note_done, r);
  for (int k = 0; k < r->count; k++) job_end_done_batch(h->all, &r->row[k]);
  free(r);
}

static void tick(job_shared *h) {
  static void (*const steps[])(job_shared *) = {beat, bury, look_at_held, look_for_done_batches};
  for (size_t k = 0; k < sizeof steps / sizeof *steps && store_is_up(h->all->store); k++) {
    steps[k](h);
  }
  count(h);
  h->more = h->waiting > 0;
  h->tick = loop_now() + tick_seconds;
}

/* ---- What other daemons tell ---- */

static void hear_word(job_shared *h, const char *word) {
  job *c = strlen(word) == JOB_ID - 1 ? job_find(h->all, word) : NULL;
  if (*word == '+') h->more = true;
  if (*word == '*') h->tick = 0;
  if (c != NULL) job_check(c, h->id);
}

static void hear(job_shared *h) {
  for (char *text; (text = store_hear(h->all->store)) != NULL; free(text)) {
    for (char *rest = text, *word; (word = strsep(&rest, " ")) != NULL;) hear_word(h, word);
  }
}

static void readable(void *self, uint32_t events) {
  job_shared *h = self;
  (void)events;
  hear(h);
}

/* ---- Running ---- */

/* Connects if it has to, and watches the descriptor of a new connection; that of the last one was
 * closed, which took it off the loop. */
static bool tend(job_shared *h) {
  int generation;
  store *s = h->all->store;
  if (!store_tend(s)) return false;
  const int fd = store_descriptor(s, &generation);
  if (generation == h->generation) return true;
  h->tick = h->beat = 0;
  if (loop_watch(h->all->loop, fd, EPOLLIN, &h->source)) h->generation = generation;
  return true; /* unwatched it is heard with each tick, and watched with a later one */
}

double job_shared_due(const job_shared *h) {
  const jobs *j = h->all;
  if (!store_is_up(j->store)) return h->tick;
  return may_take(h) || store_has_news(j->store) ? 0 : h->tick;
}

void job_shared_run(job_shared *h) {
  if (!tend(h)) {
    h->more = false;
    h->tick = loop_now() + retry_seconds;
    return;
  }
  hear(h);
  if (h->tick <= loop_now()) tick(h);
}

job_shared *job_shared_new(jobs *j) {
  uint8_t bytes[(JOB_HOLDER - 1) / 2];
  job_shared *h = calloc(1, sizeof *h);
  if (h == NULL || getrandom(bytes, sizeof bytes, 0) != (ssize_t)sizeof bytes) {
    free(h);
    return NULL;
  }
  h->all = j;
  h->source = (loop_source){readable, h};
  for (size_t k = 0; k < sizeof bytes; k++) snprintf(h->id + 2 * k, 3, "%02x", bytes[k]);
  store_sign(j->store, h->id);
  return h;
}

const char *job_shared_id(const job_shared *h) {
  return h->id;
}

void job_shared_free(job_shared **h) {
  if (*h == NULL) return;
  store_leave((*h)->all->store, (*h)->id);
  (void)store_tell((*h)->all->store, "+");
  free(*h);
  *h = NULL;
}
