#include "outcome.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "media.h"
#include "range.h"

/* The bytes are the values of Link fields, one a line. */
static void reply_links(exchange *x, const pool_outcome *o) {
  char text[8192];
  const ssize_t length = pread(o->fd, text, sizeof text - 1, 0);
  text[length > 0 ? length : 0] = '\0';
  close(o->fd);
  for (char *rest = text, *line; (line = strsep(&rest, "\n")) != NULL;) {
    if (*line != '\0') exchange_add(x, "Link", "%s", line);
  }
  exchange_text(x, 204, "", "");
}

static void reply_worker(exchange *x, const limits *most, const pool_outcome *o) {
  (void)most;
  const bool refused = strcmp(o->type, media_type(MEDIA_PROBLEM)) == 0;
  const char *type = refused && x->plain_problem ? media_type(MEDIA_JSON) : o->type;
  if (o->status == 204) {
    reply_links(x, o);
  } else {
    exchange_file(x, o->status, type, o->coding, o->fd, o->size);
    range_apply(x, NULL);
  }
}

/* " in phase factor", or nothing when the worker never told. */
static const char *where(const pool_outcome *o, char room[64]) {
  snprintf(room, 64, *o->phase != '\0' ? " in phase %s" : "", o->phase);
  return room;
}

static void reply_memory(exchange *x, const limits *most, const pool_outcome *o) {
  char room[64];
  exchange_refuse(x, 422, "the solve%s needs more than %lld bytes of memory (memory-bytes)",
                  where(o, room), (long long)most->memory_bytes);
}

static void reply_time(exchange *x, const limits *most, const pool_outcome *o) {
  char room[64];
  exchange_refuse(x, 504, "the solve was stopped%s after %g s (limit: seconds)", where(o, room),
                  most->seconds);
}

static void reply_crash(exchange *x, const limits *most, const pool_outcome *o) {
  char room[64];
  (void)most;
  exchange_refuse(x, 500, "the worker died%s; the log knows more under request %s", where(o, room),
                  x->id);
}

static void reply_stopped(exchange *x, const limits *most, const pool_outcome *o) {
  (void)most, (void)o;
  exchange_add(x, "Retry-After", "%d", 10);
  exchange_refuse(x, 503, "the service is being stopped");
}

static void (*const replies[])(exchange *, const limits *, const pool_outcome *) = {
    [POOL_REPLY] = reply_worker, [POOL_MEMORY] = reply_memory,   [POOL_TIME] = reply_time,
    [POOL_CRASH] = reply_crash,  [POOL_STOPPED] = reply_stopped,
};

void outcome_reply(exchange *x, const limits *most, const pool_outcome *o) {
  x->worker = o->worker;
  x->run_seconds = o->seconds;
  x->points = o->points;
  replies[o->end](x, most, o);
}

void outcome_refuse_full(exchange *x, const pool *p, int64_t queue) {
  exchange_add(x, "Retry-After", "%d", pool_retry_after(p));
  if (pool_waiting(p) < queue) {
    exchange_refuse(x, 503, "the service has no memory for it, or is being stopped");
    return;
  }
  exchange_refuse(x, 503, "all workers are busy and %lld requests wait (limit: queue)",
                  (long long)queue);
}
