/* The jobs in memory: made, watched, looked at, dismissed. */
#include <math.h>
#include <search.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
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

/* ---- Dismissing ---- */

/* One that is not over is in memory. The batch may be gone first. */
static void dismiss_part(const void *node, VISIT when, void *batch) {
  job *part = *(job *const *)node;
  if ((when != postorder && when != leaf) || part->batch != batch) return;
  part->batch = NULL;
  if (job_state_is_final((job_state)part->row.state)) return;
  job_stop(part);
  job_become(part, JOB_DISMISSED, "dismissed with its batch");
}

static store_result write_dismissed(store *s, const job_row *row) {
  store_result result = store_begin(s);
  if (result == STORE_OK) result = store_update(s, row, "", NULL, 0);
  if (result == STORE_OK) result = store_drop_small(s, row->number, -1);
  if (result == STORE_OK) result = store_log(s, row->number, row->updated, "dismissed");
  return store_end(s, result);
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
  if (c->row.parts > 0) twalk_r(c->all->by_id, dismiss_part, c);
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
