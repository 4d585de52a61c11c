#include "events.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "http.h"
#include "job_routes.h"
#include "job_status.h"
#include "negotiate.h"

enum { retry_seconds = 10 }; /* until one more may be tried */

typedef struct stream stream;
struct stream {
  stream *next, **at;
  const service *service;
  exchange *x;
  job_watch watch;
  job_view now;
  int64_t last; /* id of the last event sent, or known to the client */
  bool owes;    /* a status is due, whatever the job keeps */
  bool ended;   /* nothing follows what is due */
  bool beats;   /* a heartbeat is due */
  bool broken;  /* there was no memory for what was due */
  double quiet; /* when the next one will be */
  char *text;   /* being sent; malloc'ed */
  size_t size, sent;
};

struct streams {
  const parameters *set;
  stream *first;
  int64_t count;
  bool stopped;
};

/* ---- One event as text ---- */

static const char *const names[] = {[JOB_EVENT_STATUS] = "status",
                                    [JOB_EVENT_PROGRESS] = "progress",
                                    [JOB_EVENT_PHASE] = "phase",
                                    [JOB_EVENT_RESIDUAL] = "residual"};

static void set_text(stream *t, int length, char *text) {
  t->broken = length < 0;
  t->text = length >= 0 ? text : NULL;
  t->size = length >= 0 ? (size_t)length : 0;
  t->sent = 0;
}

static void write_status(stream *t) {
  size_t size = 0;
  char *text = NULL, *bytes = job_status_bytes(&t->now, t->x->base, false, NULL, &size);
  const int length = bytes == NULL ? -1
                                   : asprintf(&text, "id: %lld\nevent: status\ndata: %.*s\n\n",
                                              (long long)t->last, (int)size, bytes);
  free(bytes);
  set_text(t, length, text);
}

/* The phase is the library's word: no quotes in it. */
static void write_event(stream *t, const job_event *e) {
  char *text = NULL, residual[48] = "";
  if (e->residual > 0) snprintf(residual, sizeof residual, ",\"residual\":%.6e", e->residual);
  const int length =
      asprintf(&text, "id: %lld\nevent: %s\ndata: {\"progress\":%d,\"phase\":\"%s\"%s}\n\n",
               (long long)e->id, names[e->kind], e->progress, e->phase, residual);
  set_text(t, length, text);
}

static void write_heartbeat(stream *t) {
  char *text = strdup(":\n\n");
  set_text(t, text != NULL ? 3 : -1, text);
}

/* ---- What comes next ---- */

/* Did the client miss events that the job no longer keeps? */
static bool missed(const stream *t) {
  const job_event *oldest = job_event_after(t->now.active, 0);
  return oldest != NULL && t->last > 0 && t->last < oldest->id - 1 &&
         job_events_dropped(t->now.active);
}

static void next_of_job(stream *t) {
  if (missed(t)) {
    t->last = job_event_after(t->now.active, 0)->id - 1;
    write_status(t);
    return;
  }
  const job_event *e = job_event_after(t->now.active, t->last);
  if (e == NULL) return;
  t->last = e->id;
  if (e->kind == JOB_EVENT_STATUS) {
    write_status(t);
  } else {
    write_event(t, e);
  }
}

/* Sets the text to be sent next; none when there is nothing to say. */
static void next(stream *t) {
  if (t->owes) {
    t->owes = false;
    write_status(t);
  } else if (t->now.active != NULL) {
    next_of_job(t);
  }
  if (t->text == NULL && t->beats && !t->broken) write_heartbeat(t);
  t->beats = false;
  if (t->text != NULL) t->quiet = loop_now() + t->service->set->heartbeat_seconds;
}

static ssize_t read_stream(void *self, char *room, size_t size) {
  stream *t = self;
  if (t->text == NULL) next(t);
  if (t->broken) return EXCHANGE_BROKEN; /* the client comes again, for what it lacks */
  if (t->text == NULL) return t->ended ? EXCHANGE_END : 0;
  const size_t left = t->size - t->sent, step = left < size ? left : size;
  memcpy(room, t->text + t->sent, step);
  t->sent += step;
  if (t->sent == t->size) {
    free(t->text);
    t->text = NULL;
  }
  return (ssize_t)step;
}

static void changed(void *self, const job_view *now) {
  stream *t = self;
  t->now = *now;
  if (now->active == NULL) {
    t->owes = t->ended = true;
    t->last = job_event_last(&now->row);
  }
  http_wake(t->x);
}

/* ---- All of them ---- */

static double due(void *self) {
  const streams *all = self;
  double first = INFINITY;
  for (const stream *t = all->first; t != NULL; t = t->next) first = fmin(first, t->quiet);
  return first;
}

static void beat(void *self) {
  streams *all = self;
  const double now = loop_now();
  for (stream *t = all->first; t != NULL; t = t->next) {
    if (t->quiet > now) continue;
    t->quiet = now + all->set->heartbeat_seconds;
    t->beats = true;
    http_wake(t->x);
  }
}

streams *streams_new(loop *l, const parameters *set) {
  streams *all = calloc(1, sizeof *all);
  if (all == NULL) return NULL;
  all->set = set;
  loop_add(l, (loop_chore){due, beat, all});
  return all;
}

void streams_free(streams **all) {
  free(*all);
  *all = NULL;
}

void streams_stop(streams *all) {
  all->stopped = true;
  for (stream *t = all->first; t != NULL; t = t->next) {
    t->ended = true;
    t->now.active = NULL;
    job_watch_off(&t->watch);
    http_wake(t->x);
  }
}

/* ---- The route ---- */

static int64_t last_known(const exchange *x) {
  char room[64];
  const char *text = http_field(x, "Last-Event-ID", room, sizeof room);
  return text != NULL && *text >= '0' && *text <= '9' ? strtoll(text, NULL, 10) : 0;
}

/* Where a client begins: after the last event it knows, or with the state of now. */
static void begin(stream *t, int64_t known) {
  t->ended = t->now.active == NULL;
  t->owes = known == 0 || t->ended || t->now.elsewhere;
  t->last = known != 0 && !t->ended ? known : t->ended ? job_event_last(&t->now.row) : t->now.event;
}

static void start(const service *s, exchange *x, const job_view *view) {
  streams *all = s->streams;
  stream *t = x->task = calloc(1, sizeof *t);
  if (t == NULL) {
    exchange_refuse(x, 503, "out of memory");
    return;
  }
  *t = (stream){.service = s, .x = x, .now = *view, .next = all->first, .at = &all->first};
  t->quiet = loop_now() + s->set->heartbeat_seconds;
  t->watch = (job_watch){.changed = changed, .self = t};
  if (t->next != NULL) t->next->at = &t->next;
  all->first = t;
  all->count++;
  begin(t, last_known(x));
  if (view->active != NULL) job_watch_on(view->active, &t->watch);
  exchange_add(x, "Cache-Control", "no-store");
  exchange_stream(x, 200, "text/event-stream", (exchange_source){t, read_stream});
}

static int64_t streams_of(const streams *all, const char *owner) {
  int64_t count = 0;
  for (const stream *t = all->first; t != NULL; t = t->next) count += !strcmp(t->x->owner, owner);
  return count;
}

/* First what its token may have: more than that is not to be had by waiting for others. */
static bool has_room(const streams *all, exchange *x) {
  const bool is_limited = x->most.streams < INT64_MAX;
  const int64_t own = is_limited ? streams_of(all, x->owner) : 0;
  if (is_limited && own >= x->most.streams) {
    exchange_add(x, "Retry-After", "%d", retry_seconds);
    exchange_refuse(x, 429,
                    "%lld event streams are open, one more would be above %lld (limit: streams of "
                    "the token)",
                    (long long)own, (long long)x->most.streams);
    return false;
  }
  if (!all->stopped && all->count < all->set->streams) return true;
  exchange_add(x, "Retry-After", "%d", retry_seconds);
  exchange_refuse(x, 503, "%lld event streams are open (limit: streams)", (long long)all->count);
  return false;
}

void events_serve(const service *s, exchange *x) {
  const char *const offers[] = {"text/event-stream"};
  job_view view;
  if (!job_of_route(s, x, &view) || negotiate(x, offers, 1) < 0) return;
  if (view.active == NULL && last_known(x) >= job_event_last(&view.row)) {
    exchange_text(x, 204, "", "");
  } else if (has_room(s->streams, x)) {
    start(s, x, &view);
  }
}

void events_end(const service *s, exchange *x) {
  stream *t = x->task;
  if (t == NULL) return;
  job_watch_off(&t->watch);
  *t->at = t->next;
  if (t->next != NULL) t->next->at = t->at;
  s->streams->count--;
  free(t->text);
  free(t);
  x->task = NULL;
}
