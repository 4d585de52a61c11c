#include "job_status.h"

#include <math.h>
#include <stdio.h>
#include <time.h>

#include "member.h"

#define RELATION "http://www.opengis.net/def/rel/ogc/1.0/"

enum { LOG_LINES = 50 };

void job_status_time(double seconds, char text[32]) {
  const time_t whole = (time_t)floor(seconds);
  const int thousandths = (int)(1e3 * (seconds - (double)whole));
  struct tm t;
  char date[24];
  gmtime_r(&whole, &t);
  strftime(date, sizeof date, "%Y-%m-%dT%H:%M:%S", &t);
  snprintf(text, 32, "%s.%03dZ", date, thousandths);
}

/* ---- Members ---- */

static void emit_time(emit *e, const char *key, double seconds) {
  char text[32];
  if (seconds <= 0) return;
  job_status_time(seconds, text);
  member_text(e, key, text);
}

static void emit_string(emit *e, const char *key, const char *text) {
  member_text(e, key, *text != '\0' ? text : NULL);
}

typedef struct {
  unsigned states; /* in which it is shown: set of 1 << job_state */
  const char *path, *relation, *type, *title;
} link_row;

#define IN(state) (1u << JOB_##state)
#define ANY ~0u

static const link_row links[] = {
    {ANY, "", "self", "application/json", "This job"},
    {IN(ACCEPTED) | IN(RUNNING), "", "monitor", "application/json", "How far it is"},
    {IN(ACCEPTED) | IN(RUNNING), "/events", RELATION "events", "text/event-stream",
     "What happens to it, as it happens"},
    {IN(SUCCESSFUL), "/results", RELATION "results", "application/json", "Its results"},
    {IN(FAILED), "/results", RELATION "exceptions", "application/problem+json", "Why it failed"},
};

static void emit_links(emit *e, const job_row *row, const char *base) {
  char href[EXCHANGE_BASE + JOB_ID + 32];
  emit_key(e, "links");
  emit_list(e);
  for (size_t k = 0; k < sizeof links / sizeof *links; k++) {
    if ((links[k].states >> row->state & 1) == 0) continue;
    snprintf(href, sizeof href, "%s/jobs/%s%s", base, row->id, links[k].path);
    emit_object(e);
    emit_string(e, "href", href);
    emit_string(e, "rel", links[k].relation);
    emit_string(e, "type", links[k].type);
    emit_string(e, "title", links[k].title);
    emit_end(e);
  }
  emit_end(e);
}

static void emit_line(void *context, double time, const char *text) {
  emit *e = context;
  emit_object(e);
  emit_time(e, "time", time);
  emit_string(e, "text", text);
  emit_end(e);
}

static void emit_log(emit *e, store *s, int64_t number) {
  emit_key(e, "log");
  emit_list(e);
  (void)store_read_log(s, number, LOG_LINES, emit_line, e);
  emit_end(e);
}

static void emit_more(emit *e, const job_view *view) {
  const job_row *row = &view->row;
  emit_string(e, "message", row->message);
  emit_string(e, "phase", view->phase);
  if (view->residual > 0) member_number(e, "residual", view->residual);
  member_integer(e, "progress", row->progress);
  emit_time(e, "created", row->created);
  emit_time(e, "started", row->started);
  emit_time(e, "finished", row->finished);
  emit_time(e, "updated", row->updated);
  emit_time(e, "expires", row->expires);
  member_integer(e, "attempts", row->attempts);
  member_integer(e, "priority", row->priority);
  if (row->points > 0) member_integer(e, "points", row->points);
  if (row->estimate > 0) member_integer(e, "estimatedMemory", row->estimate);
  if (row->parts > 0) member_integer(e, "parts", row->parts);
}

void job_status_emit(emit *e, const job_view *view, const char *base, bool minimal, store *s) {
  const job_row *row = &view->row;
  emit_object(e);
  emit_string(e, "processID", row->process);
  emit_string(e, "type", "process");
  emit_string(e, "jobID", row->id);
  emit_string(e, "status", job_state_name((job_state)row->state));
  if (!minimal) emit_more(e, view);
  emit_links(e, row, base);
  if (!minimal && s != NULL && row->parent == 0) emit_log(e, s, row->number);
  emit_end(e);
}

char *job_status_bytes(const job_view *view, const char *base, bool minimal, store *s,
                       size_t *size) {
  emit *e = emit_new(EMIT_JSON);
  if (e == NULL) return NULL;
  job_status_emit(e, view, base, minimal, s);
  char *text = emit_take_text(e, size);
  emit_free(&e);
  return text;
}

void job_status_reply(exchange *x, int status, const job_view *view, bool minimal, store *s) {
  size_t size = 0;
  char *bytes = job_status_bytes(view, x->base, minimal, s, &size);
  if (bytes == NULL) {
    exchange_refuse(x, 503, "out of memory");
  } else {
    exchange_bytes(x, status, media_type(MEDIA_JSON), bytes, size);
  }
}

/* FNV-1a, 64 bits: what changes is seen; nobody gains by making two documents of one job agree. */
void job_status_tag(const char *bytes, size_t size, char tag[24]) {
  uint64_t sum = 14695981039346656037u;
  for (size_t k = 0; k < size; k++) sum = (sum ^ (unsigned char)bytes[k]) * 1099511628211u;
  snprintf(tag, 24, "\"%016llx\"", (unsigned long long)sum);
}

/* ---- Problems ---- */

void job_refuse_missing(exchange *x, const char *id) {
  problem p;
  problem_begin_type(&p, PROBLEM_NO_SUCH_JOB, 404, "there is no job \"%.64s\"", id);
  exchange_problem(x, &p);
}

void job_refuse_dismissed(exchange *x, const char *id) {
  exchange_refuse(x, 410, "job %.64s was dismissed", id);
}

void job_refuse_unready(exchange *x, const job_row *row) {
  problem p;
  problem_begin_type(&p, PROBLEM_RESULT_NOT_READY, 404, "job %s is %s, its progress is %d %%",
                     row->id, job_state_name((job_state)row->state), row->progress);
  exchange_problem(x, &p);
}

void job_refuse_failed(exchange *x, jobs *j, const job_row *row) {
  size_t size = 0;
  void *bytes = store_problem(jobs_store(j), row->number, &size);
  if (bytes == NULL) {
    exchange_refuse(x, row->status > 0 ? row->status : 500, "job %s failed: %s", row->id,
                    row->message);
    return;
  }
  exchange_bytes(x, row->status, media_type(x->plain_problem ? MEDIA_JSON : MEDIA_PROBLEM), bytes,
                 size);
}

void job_refuse_store(exchange *x, store_result why) {
  if (why == STORE_FULL) {
    exchange_refuse(
        x, 507,
        "the disk of the service, or what may be used of it, is full (job-bytes, data-bytes)");
  } else if (why == STORE_DOWN || why == STORE_BUSY ||
             why == STORE_TAKEN) { /* taken by what has gone since */
    exchange_add(x, "Retry-After", "5");
    exchange_refuse(x, 503,
                    "the store of the service does not answer, or lacks memory or descriptors now");
  } else {
    exchange_refuse(x, 500, "the store does not work; the log knows more under request %s", x->id);
  }
}
