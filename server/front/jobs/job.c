#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <search.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <time.h>
#include <unistd.h>

#include "job_shared.h"
#include "store_shared.h"

/* ---- The jobs in memory ---- */

static int by_id(const void *a, const void *b) {
  return strcmp(((const job *)a)->row.id, ((const job *)b)->row.id);
}

/* A batch is counted by its parts. */
static bool count(job *c, int by) {
  return c->row.parts > 0 || job_tally_add(&c->all->tally, c->row.submitter, by);
}

job *job_new(jobs *j, const job_row *row) {
  job *c = calloc(1, sizeof *c);
  if (c == NULL) return NULL;
  c->row = *row;
  c->all = j;
  c->body = c->checkpoint = -1;
  if (!count(c, 1)) {
    free(c);
    return NULL;
  }
  if (tsearch(c, &j->by_id, by_id) != NULL) return c;
  (void)count(c, -1);
  free(c);
  return NULL;
}

void job_free(job *c) {
  job_files_forget(c);
  tdelete(c, &c->all->by_id, by_id);
  (void)count(c, -1);
  while (c->watches != NULL) job_watch_off(c->watches);
  if (c->batch != NULL && c->batch->members > 0) c->batch->members--;
  if (c->body >= 0) close(c->body);
  if (c->checkpoint >= 0) close(c->checkpoint);
  job_files_clear(c);
  job_clear_overtaken(c);
  free(c->extra);
  free(c->problem);
  free(c->events);
  free(c);
}

job *job_find(jobs *j, const char *id) {
  job key;
  snprintf(key.row.id, sizeof key.row.id, "%s", id);
  job **found = tfind(&key, &j->by_id, by_id);
  return found != NULL ? *found : NULL;
}

job_view job_look(const job *c) {
  job_view view = {.row = c->row, .active = (job *)c};
  if (c->events != NULL) view.event = c->events->last;
  view.elsewhere = c->elsewhere;
  if (c->row.state == JOB_RUNNING) {
    memcpy(view.phase, c->row.phase, sizeof view.phase);
    view.residual = c->row.residual;
  }
  return view;
}

void job_touch(job *c) {
  c->row.updated = fmax(unix_now(), c->row.updated);
}

/* A state of the table, with what to say about it; to be saved. */
void job_become(job *c, job_state state, const char *format, ...) {
  va_list arguments;
  if (!job_state_may((job_state)c->row.state, state)) abort(); /* a bug: no input leads here */
  if (c->changed) job_overtake(c);
  va_start(arguments, format);
  vsnprintf(c->row.message, sizeof c->row.message, format, arguments);
  va_end(arguments);
  c->row.state = (int)state;
  job_touch(c);
  if (state == JOB_RUNNING && c->row.started <= 0) c->row.started = c->row.updated;
  if (state >= JOB_SUCCESSFUL) {
    c->row.finished = fmax(c->row.updated, c->all->last + 1e-6);
    c->all->last = c->row.finished;
    if (c->row.parent == 0) c->row.expires = c->row.finished + c->all->set->result_seconds;
  }
  job_save(c);
}

/* ---- Watching ---- */

void job_watch_on(job *which, job_watch *w) {
  w->next = which->watches;
  if (w->next != NULL) w->next->at = &w->next;
  w->at = &which->watches;
  which->watches = w;
}

void job_watch_off(job_watch *w) {
  if (w->at == NULL) return;
  *w->at = w->next;
  if (w->next != NULL) w->next->at = w->at;
  w->next = NULL;
  w->at = NULL;
}

/* A second late, so that it is the last one whatever its last milliseconds brought. */
int64_t job_event_last(const job_row *row) {
  return (int64_t)(1e3 * row->updated) + 1000;
}

/* Ids are milliseconds since 1970, and one more where that is not more than the last. */
static void add_event(job *c, job_event_kind kind) {
  if (c->events == NULL) c->events = calloc(1, sizeof *c->events);
  job_events *e = c->events;
  if (e == NULL) return; /* who watches then sees states only */
  const double now = unix_now();
  const bool over = job_state_is_final((job_state)c->row.state);
  const int64_t id = over ? job_event_last(&c->row) : (int64_t)(1e3 * now);
  e->last = id > e->last ? id : e->last + 1;
  job_event *event = &e->ring[e->count++ % JOB_EVENTS];
  *event = (job_event){
      .id = e->last, .kind = kind, .state = c->row.state, .progress = c->row.progress, .time = now};
  memcpy(event->phase, c->row.phase, sizeof event->phase);
  event->residual = c->row.residual;
}

const job_event *job_event_after(const job *which, int64_t after) {
  const job_events *e = which->events;
  const int kept = e == NULL ? 0 : e->count < JOB_EVENTS ? e->count : JOB_EVENTS;
  for (int k = kept; k > 0; k--) {
    const job_event *event = &e->ring[(e->count - k) % JOB_EVENTS];
    if (event->id > after) return event;
  }
  return NULL;
}

bool job_events_dropped(const job *which) {
  return which->events != NULL && which->events->count > JOB_EVENTS;
}

void job_tell(job *c, job_event_kind kind) {
  if (c->row.state == JOB_RUNNING || c->watches != NULL) add_event(c, kind);
  job_view view = job_look(c);
  const bool over = job_state_is_final((job_state)c->row.state);
  if (over) view.active = NULL;
  for (job_watch *w = c->watches, *next; w != NULL; w = next) {
    next = w->next;
    if (over) job_watch_off(w);
    w->changed(w->self, &view);
  }
}

/* ---- Looking ---- */

/* What cannot be stored yet is not told: the row is then as it was. */
job_view jobs_view(jobs *j, const job_row *row) {
  job *c = j->shared != NULL ? job_shared_look(j, row) : job_find(j, row->id);
  job_view view = {.row = *row, .active = c};
  if (c != NULL && !c->changed) view = job_look(c);
  if (job_state_is_final((job_state)view.row.state)) view.active = NULL;
  return view;
}

/* Without an owner there are no tokens: all is everybody's. */
static bool is_for(const char *owner, const job_row *row) {
  return *owner == '\0' || strcmp(owner, row->submitter) == 0;
}

store_result jobs_find(jobs *j, const char *owner, const char *id, job_view *view) {
  job_row row;
  jobs_flush(j);
  store_result result = store_job(j->store, id, &row);
  if (result == STORE_OK && !is_for(owner, &row)) result = STORE_NONE;
  *view = result == STORE_OK ? jobs_view(j, &row) : (job_view){0};
  return result;
}

typedef struct {
  jobs *jobs;
  store_visit *visit;
  void *context;
} refresh;

static bool visit_fresh(void *context, const job_row *row) {
  const refresh *r = context;
  const job *c = job_find(r->jobs, row->id);
  const bool is_newer =
      c != NULL && !c->changed && !c->elsewhere &&
      !job_state_is_final((job_state)row->state); /* dismissed by another daemon */
  job_row now = is_newer ? c->row : *row;
  if (r->jobs->shared != NULL) job_shared_fill(r->jobs, &now);
  return r->visit(r->context, &now);
}

store_result jobs_list(jobs *j, const store_filter *f, store_visit *visit, void *context) {
  refresh r = {j, visit, context};
  jobs_flush(j);
  return store_list(j->store, f, visit_fresh, &r);
}

store *jobs_store(jobs *j) {
  jobs_flush(j);
  return j->store;
}

int jobs_result(jobs *j, const job_row *row) {
  return job_files_open(j, row, JOB_RESULT);
}

static int64_t waiting(const jobs *j) {
  return j->shared != NULL ? job_shared_waiting(j->shared) : (int64_t)job_queue_length(j->queue);
}

int64_t jobs_room(const jobs *j) {
  return j->set->job_queue - waiting(j) - j->held;
}

void jobs_hold(jobs *j, int places) {
  j->held += places;
}

int jobs_retry_after(const jobs *j) {
  return (int)ceil(fmin(300, fmax(1, j->mean)));
}

const char *jobs_holder(const jobs *j) {
  return j->shared != NULL ? job_shared_id(j->shared) : "";
}

int64_t jobs_of(const jobs *j, const char *submitter) {
  if (j->shared != NULL) return store_active_of(j->store, submitter);
  return job_tally_of(&j->tally, submitter);
}

void jobs_on_owners(jobs *j, const job_owners *owners) {
  j->owners = *owners;
}

int64_t jobs_most_memory(const jobs *j) {
  const int64_t worker = j->set->limits.memory_bytes;
  return worker < j->budget ? worker : j->budget;
}

/* What one process may have the check of the request has looked at. */
int64_t jobs_most_memory_of(const jobs *j, const char *process, int64_t points) {
  if (!executor_takes(j->executor, process, points)) return jobs_most_memory(j);
  return executor_is_here(j->executor) ? j->budget : INT64_MAX;
}

job_counts jobs_counts(const jobs *j) {
  job_counts counts = j->counts;
  counts.waiting = waiting(j);
  return counts;
}

void jobs_on_change(jobs *j, void (*changed)(void *self), void *self) {
  j->told = changed;
  j->told_self = self;
}

/* ---- Accepting ---- */

static bool make_id(char id[JOB_ID]) {
  uint8_t bytes[(JOB_ID - 1) / 2];
  if (getrandom(bytes, sizeof bytes, 0) != (ssize_t)sizeof bytes) return false;
  for (size_t k = 0; k < sizeof bytes; k++) snprintf(id + 2 * k, 3, "%02x", bytes[k]);
  return true;
}

/* A new job as the order has it. */
static job *job_of_order(jobs *j, const job_order *o) {
  job_row row = o->row;
  if (!make_id(row.id)) return NULL;
  row.state = JOB_ACCEPTED;
  row.created = row.updated = unix_now();
  snprintf(row.message, sizeof row.message, "waits for a worker");
  for (int k = 0; k < 3; k++) row.subscribed |= *o->extra->uri[k] != '\0';
  job *c = job_new(j, &row);
  if (c == NULL) return NULL;
  c->stored = o->stored;
  c->stored_self = o->self;
  c->extra = malloc(sizeof *c->extra);
  if (c->extra != NULL) {
    *c->extra = *o->extra;
    return c;
  }
  job_free(c);
  return NULL;
}

static job *part_of(job *batch, const job_part *p, int place) {
  job_row row = batch->row;
  if (!make_id(row.id)) return NULL;
  memcpy(row.process, p->process, sizeof row.process);
  row.content = MEDIA_CBOR;
  row.content_coding = CODING_IDENTITY;
  row.offset = p->offset;
  row.size = p->size;
  row.points = p->points;
  row.estimate = p->estimate;
  row.part = place;
  row.parts = row.reusable = row.subscribed = 0;
  job *c = job_new(batch->all, &row);
  if (c != NULL) c->batch = batch;
  return c;
}

static void free_with_parts(job *c) {
  while (c->parts != NULL) {
    job *part = c->parts;
    c->parts = part->sibling;
    job_free(part);
  }
  job_free(c);
}

static bool add_parts(job *c, const job_part *parts) {
  job **end = &c->parts;
  for (int k = 0; k < c->row.parts; k++) {
    *end = part_of(c, &parts[k], k);
    if (*end == NULL) return false;
    end = &(*end)->sibling;
  }
  return true;
}

int job_places(const job *c) {
  return c->row.parts > 0 ? c->row.parts : 1;
}

/* While a large request was being kept, an equal one may have come and gone the same way. A shared
 * store finds that out itself. */
static bool is_key_taken(const job *c) {
  jobs *j = c->all;
  job_row other;
  char digest[JOB_DIGEST];
  if (*c->extra->key == '\0' || c->row.size < j->set->aside_bytes) return false;
  return store_by_key(jobs_store(j), c->row.submitter, c->extra->key, &other, digest) == STORE_OK;
}

/* Its request is kept. */
static void accept_job(job *c, int error) {
  jobs_hold(c->all, -job_places(c));
  if (error != 0 || is_key_taken(c)) {
    job_refuse(c, error != 0 ? store_blame("job", error) : STORE_TAKEN);
    return;
  }
  c->row.created = c->row.updated = unix_now(); /* which may have been set since */
  for (job *part = c->parts; part != NULL; part = part->sibling) {
    part->row.created = part->row.updated = c->row.created;
  }
  job_save(c);
}

store_result jobs_add(jobs *j, const job_order *order) {
  job *c = job_of_order(j, order);
  if (c != NULL && add_parts(c, order->parts)) {
    jobs_hold(j, job_places(c));
    job_files_keep(c, JOB_REQUEST, order->body, (size_t)c->row.size, accept_job);
    return STORE_OK;
  }
  if (c != NULL) free_with_parts(c);
  if (order->body >= 0) close(order->body);
  return STORE_FAILED;
}

store_result jobs_add_answered(jobs *j, const job_order *order, const job_row *other) {
  job *c = job_of_order(j, order);
  if (c == NULL) return STORE_FAILED;
  if (!job_files_copy(c, other)) {
    const store_result result = store_blame("job", errno);
    job_free(c);
    return result;
  }
  c->row.result_size = other->result_size;
  c->row.result_coding = other->result_coding;
  c->row.started = c->row.created;
  c->row.progress = 100;
  job_become(c, JOB_SUCCESSFUL, "answered with the result of job %s, an equal request", other->id);
  return STORE_OK;
}

void jobs_forget(jobs *j, void *self) {
  for (job *c = j->changed; c != NULL; c = c->next_changed) {
    if (c->stored_self == self) c->stored = NULL;
  }
  job_files_orphan(j, self);
}

/* ---- Dismissing ---- */

static bool dismiss_part(void *context, const job_row *row) {
  job *part = job_find(context, row->id);
  if (part == NULL || job_state_is_final((job_state)part->row.state)) return true;
  job_stop(part);
  part->batch = NULL; /* which may be gone first */
  job_become(part, JOB_DISMISSED, "dismissed with its batch");
  return true;
}

static store_result write_dismissed(store *s, const job_row *row) {
  store_result result = store_begin(s);
  if (result == STORE_OK) result = store_update(s, row, "", NULL, 0);
  if (result == STORE_OK) result = store_drop_small(s, row->number, -1);
  if (result == STORE_OK) result = store_log(s, row->number, row->updated, "dismissed");
  if (result == STORE_OK) result = store_commit(s);
  if (result != STORE_OK) store_rollback(s);
  return result;
}

/* One that is over: only its row is left to change, and its files. On a full disk these go first.
 */
static store_result dismiss_stored(jobs *j, const job_row *row, job_view *view) {
  view->row = *row;
  view->row.state = JOB_DISMISSED;
  view->row.updated = fmax(unix_now(), row->updated);
  snprintf(view->row.message, sizeof view->row.message, "dismissed");
  store_result result = write_dismissed(j->store, &view->row);
  job_files_drop(j, row, true);
  return result == STORE_FULL ? write_dismissed(j->store, &view->row) : result;
}

static void dismiss_active(job *c) {
  jobs *j = c->all;
  if (c->row.parts > 0) {
    store_filter parts = {.states = ~0u,
                          .created_most = INFINITY,
                          .has_parent = true,
                          .parent = c->row.number,
                          .limit = INT64_MAX};
    (void)store_list(j->store, &parts, dismiss_part, j);
  }
  job_stop(c);
  job_become(c, JOB_DISMISSED, "dismissed");
}

store_result jobs_dismiss(jobs *j, const job_row *row, job_view *view) {
  if (j->shared != NULL) return job_shared_dismiss(j, row, view);
  job *c = job_find(j, row->id);
  *view = (job_view){0};
  if (c == NULL) return dismiss_stored(j, row, view);
  if (c->row.state != JOB_DISMISSED) dismiss_active(c); /* else it is, but not yet stored */
  *view = job_look(c);
  view->active = NULL;
  jobs_flush(j); /* c may be gone after this */
  return j->retry > 0 ? STORE_FULL : STORE_OK;
}
