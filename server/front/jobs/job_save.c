/* Storing what changed. All changes of a round of the loop are one transaction, and so one fsync.
 * If it fails, each job is tried alone: a new one that cannot be stored is refused; what ended is
 * tried again until it can be. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "job_shared.h"
#include "log.h"
#include "store_shared.h"

static const double retry_seconds = 1;

void job_save(job *c) {
  jobs *j = c->all;
  c->again = c->changed; /* perhaps since it was written */
  if (c->changed) return;
  c->changed = true;
  c->next_changed = NULL;
  *j->last_changed = c;
  j->last_changed = &c->next_changed;
}

/* ---- The log ---- */

enum { NOTE = JOB_MESSAGE + 32 };

static void write_note(const job *c, char text[NOTE]) {
  snprintf(text, NOTE, "%s: %s", job_state_name((job_state)c->row.state), c->row.message);
}

/* Without memory the log lacks it. */
void job_overtake(job *c) {
  char text[NOTE];
  job_note **end = &c->overtaken;
  write_note(c, text);
  const size_t size = strlen(text) + 1;
  job_note *n = malloc(sizeof *n + size);
  if (n == NULL) return;
  n->next = NULL;
  n->when = c->row.updated;
  memcpy(n->text, text, size);
  while (*end != NULL) end = &(*end)->next;
  *end = n;
}

void job_clear_overtaken(job *c) {
  while (c->overtaken != NULL) {
    job_note *n = c->overtaken;
    c->overtaken = n->next;
    free(n);
  }
}

static store_result note(job *c) {
  char text[NOTE];
  store *s = c->all->store;
  store_result result = STORE_OK;
  for (const job_note *n = c->overtaken; n != NULL && result == STORE_OK; n = n->next) {
    result = store_log(s, c->row.number, n->when, n->text);
  }
  write_note(c, text);
  return result == STORE_OK ? store_log(s, c->row.number, c->row.updated, text) : result;
}

/* ---- Limits of submitters ---- */

/* A new job whose submitter has a limit that other daemons may be using up at this moment. */
static bool is_limited(const job *c) {
  return c->all->shared != NULL && c->row.number == 0 && c->extra != NULL &&
         c->extra->jobs_most < INT64_MAX && !job_state_is_final((job_state)c->row.state);
}

/* The next submitter to be locked after `last`, by name; NULL for no more. */
static const char *next_limited(const job *first, const char *last) {
  const char *next = NULL;
  for (const job *c = first; c != NULL; c = c->next_changed) {
    const char *name = c->row.submitter;
    const bool follows = is_limited(c) && strcmp(name, last) > 0;
    if (follows && (next == NULL || strcmp(name, next) < 0)) next = name;
  }
  return next;
}

static store_result lock_limited(store *s, const job *first) {
  store_result result = STORE_OK;
  const char *name = "";
  while (result == STORE_OK && (name = next_limited(first, name)) != NULL) {
    result = store_lock_jobs(s, name);
  }
  return result;
}

/* ---- Writing ---- */

static store_result add_new(job *c) {
  static const job_extra none;
  if (is_limited(c) && !job_shared_may_add(c)) return STORE_LIMIT;
  store_result result = store_add(c->all->store, &c->row, c->extra != NULL ? c->extra : &none);
  for (job *part = c->parts; part != NULL && result == STORE_OK; part = part->sibling) {
    part->row.parent = c->row.number;
    result = store_add(c->all->store, &part->row, &none);
  }
  return result;
}

/* The subscriber's address for a state: of job_extra.uri, -1 for none. */
static const int address_for[JOB_STATES] = {[JOB_ACCEPTED] = -1,
                                            [JOB_RUNNING] = 1,
                                            [JOB_SUCCESSFUL] = 0,
                                            [JOB_FAILED] = 2,
                                            [JOB_DISMISSED] = -1};

/* A call to the subscriber is stored together with what it tells. */
static store_result order_call(job *c) {
  job_extra extra;
  const int kind = address_for[c->row.state];
  if (!c->row.subscribed || kind < 0) return STORE_OK;
  const store_result result = store_extra(c->all->store, c->row.number, &extra);
  if (result != STORE_OK || *extra.uri[kind] == '\0') return result;
  return store_add_call(c->all->store, c->row.number, kind, c->row.updated);
}

static store_result write_job(job *c) {
  store *s = c->all->store;
  c->again = false;
  if (c->all->shared != NULL) job_shared_mark(c);
  store_result result = c->row.number == 0
                            ? add_new(c)
                            : store_update(s, &c->row, c->held, c->problem, c->problem_size);
  c->lost = result == STORE_NONE;
  if (c->lost) return STORE_OK;
  if (result == STORE_OK) result = job_files_write(c);
  if (result == STORE_OK) result = order_call(c);
  return result == STORE_OK && c->row.parent == 0 ? note(c) : result;
}

/* Forgets the numbers of jobs whose transaction was undone. */
static void unnumber(job *c) {
  if (c->extra == NULL) return; /* not new: its number stays */
  c->row.number = 0;
  for (job *part = c->parts; part != NULL; part = part->sibling) part->row.number = 0;
}

static store_result write_all(store *s, job *first) {
  store_result result = store_begin(s);
  if (result == STORE_OK) result = lock_limited(s, first);
  for (job *c = first; c != NULL && result == STORE_OK; c = c->next_changed) result = write_job(c);
  if (result == STORE_OK && first->all->shared != NULL) {
    result = job_shared_tell(first->all->shared, first);
  }
  result = store_end(s, result);
  if (result == STORE_OK) return result;
  for (job *c = first; c != NULL; c = c->next_changed) unnumber(c);
  return result;
}

/* ---- After it ---- */

static void count(job *c) {
  jobs *j = c->all;
  if (job_state_is_final((job_state)c->row.state)) j->counts.ended[c->row.state]++;
}

static void tell_stored(job *c, store_result result) {
  void (*stored)(void *, const job_row *, store_result) = c->stored;
  c->stored = NULL;
  if (stored != NULL) stored(c->stored_self, &c->row, result);
}

/* Accepted for good: it may run. */
static void begin_waiting(job *c) {
  free(c->extra);
  c->extra = NULL;
  if (c->all->shared != NULL) {
    job_shared_release(c);
    return;
  }
  if (c->row.parts == 0 && c->row.state == JOB_ACCEPTED) job_enqueue(c, false);
  while (c->parts != NULL) {
    job *part = c->parts;
    c->parts = part->sibling;
    job_enqueue(part, false);
  }
}

static void end_for_good(job *c) {
  jobs *j = c->all;
  count(c);
  job_files_drop(j, &c->row, c->row.state == JOB_DISMISSED);
  j->expiry = fmin(j->expiry, c->row.expires > 0 ? c->row.expires : INFINITY);
  job_part_ended(c);
  if (j->shared == NULL) job_free(c);
}

static void settle(job *c) {
  jobs *j = c->all;
  const bool is_new = c->extra != NULL;
  c->changed = false;
  job_files_clear(c);
  job_clear_overtaken(c);
  if (c->lost) {
    job_shared_lose(c);
    return;
  }
  memcpy(c->held, c->row.holder, sizeof c->held);
  if (is_new) begin_waiting(c);
  if (j->told != NULL && c->row.subscribed) j->told(j->told_self);
  tell_stored(c, STORE_OK); /* may begin to watch it */
  if (c->again) job_save(c);
  if (c->changed) return; /* what it became since is told when that is stored */
  job_tell(c, JOB_EVENT_STATUS);
  if (job_state_is_final((job_state)c->row.state)) end_for_good(c);
  if (j->shared != NULL) job_shared_settle(c);
}

void job_refuse(job *c, store_result result) {
  job_files_drop(c->all, &c->row, true);
  while (c->parts != NULL) {
    job *part = c->parts;
    c->parts = part->sibling;
    job_free(part);
  }
  tell_stored(c, result);
  job_free(c);
}

/* One that could not be stored, alone. */
static void keep_trying(job *c, store_result result) {
  jobs *j = c->all;
  c->changed = false;
  if (c->extra != NULL) {
    job_refuse(c, result);
    return;
  }
  if (j->retry <= 0) log_say(LOG_ERROR, "store", "job %s cannot be stored, trying on", c->row.id);
  job_save(c);
  j->retry = loop_now() + retry_seconds;
}

static void write_alone(job *c) {
  c->next_changed = NULL;
  const store_result result = write_all(c->all->store, c);
  if (result == STORE_OK) {
    settle(c);
  } else {
    keep_trying(c, result);
  }
}

/* What is changed while the changes before are told waits for the next round. */
void jobs_flush(jobs *j) {
  job *first = j->changed;
  if (first == NULL || (j->retry > 0 && loop_now() < j->retry)) return;
  j->retry = 0;
  j->changed = NULL;
  j->last_changed = &j->changed;
  const bool together = write_all(j->store, first) == STORE_OK;
  for (job *c = first, *next; c != NULL; c = next) {
    next = c->next_changed;
    if (together) {
      settle(c);
    } else {
      write_alone(c);
    }
  }
}
