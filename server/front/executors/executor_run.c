/* What a run says by the files of its directory, and what is made of it. */
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "executor_kind.h"
#include "memory_file.h"
#include "pool_queue.h"
#include "problem.h"

executor_run *run_new(executor *x, const char *name, const pool_calls *calls, void *context) {
  executor_run *r = calloc(1, sizeof *r);
  if (r == NULL) return NULL;
  r->by = x;
  r->calls = calls;
  r->context = context;
  r->deadline = r->patience = INFINITY;
  r->started = loop_now();
  snprintf(r->name, sizeof r->name, "%s", name);
  snprintf(r->path, sizeof r->path, "%.*s/%s", (int)(sizeof r->path - sizeof r->name - 2), x->path,
           r->name);
  r->dir = run_dir_open(r->path);
  if (r->dir < 0) {
    free(r);
    return NULL;
  }
  r->next = x->first;
  x->first = r;
  x->count++;
  return r;
}

void run_remove(executor_run *r, bool with_files) {
  executor *x = r->by;
  executor_run **at = &x->first;
  while (*at != r) at = &(*at)->next;
  *at = r->next;
  x->count--;
  command_kill(&r->command);
  close(r->dir);
  if (with_files) run_dir_remove(x->dir, r->name);
  free(r);
}

/* ---- news ---- */

void run_begin(executor_run *r) {
  if (r->has_begun) return;
  r->has_begun = true;
  r->started = loop_now();
  if (r->deadline == INFINITY) r->deadline = r->started + r->limit;
  const ipc_news news = {.kind = IPC_READY, .time = r->started};
  if (r->calls != NULL) r->calls->heard(r->context, &news, -1);
}

/* A checkpoint is a file by now, perhaps a newer one than that which is told. */
static void hear_checkpoint(executor_run *r, ipc_news *news) {
  const int fd = run_dir_get(r->dir, "checkpoint", &news->size);
  if (fd >= 0) r->calls->heard(r->context, news, fd);
}

static void hear(executor_run *r, ipc_news *news) {
  run_begin(r);
  if (news->kind == IPC_CHECKPOINT) {
    hear_checkpoint(r, news);
  } else if (news->kind == IPC_PROGRESS) {
    memcpy(r->phase, news->phase, sizeof r->phase);
    r->calls->heard(r->context, news, -1);
  }
}

bool run_hear(executor_run *r) {
  ipc_news news;
  while (r->calls != NULL && run_dir_hear(r->dir, &r->heard, &news)) hear(r, &news);
  return faccessat(r->dir, "reply", F_OK, 0) == 0;
}

/* ---- the end ---- */

static pool_outcome outcome_of(const executor_run *r, pool_end end) {
  pool_outcome o = {.end = end, .fd = -1, .seconds = loop_now() - r->started};
  memcpy(o.phase, r->phase, sizeof o.phase);
  return o;
}

/* As the reply says; false if there is none that makes sense. */
static bool take_reply(const executor_run *r, pool_outcome *o) {
  ipc_news reply;
  if (!run_dir_get_reply(r->dir, &reply)) return false;
  o->end = reply.kind == IPC_FETCH ? POOL_ELSEWHERE : POOL_MEMORY;
  if (o->end == POOL_ELSEWHERE || reply.status == 0) return true;
  int64_t size = 0;
  o->fd = run_dir_get(r->dir, "result", &size);
  if (o->fd < 0 || size < reply.size || reply.size < 0 || reply.coding >= CODING_COUNT) {
    if (o->fd >= 0) close(o->fd);
    o->fd = -1;
    return false;
  }
  o->end = POOL_REPLY;
  o->status = reply.status;
  o->coding = reply.coding;
  o->size = (size_t)reply.size;
  o->points = reply.points;
  o->memory_bytes = reply.memory_bytes;
  memcpy(o->type, reply.type, sizeof o->type - 1);
  memcpy(o->detail, reply.detail, sizeof o->detail - 1);
  return true;
}

static void tell_end(executor_run *r, const pool_outcome *o) {
  const pool_calls *calls = r->calls;
  if (calls == NULL) return;
  r->calls = NULL;
  pool_count_run(r->process, IPC_RUN_STORED, o);
  calls->done(r->context, o);
}

void run_finish(executor_run *r, pool_end end) {
  pool_outcome o = outcome_of(r, end);
  if (r->calls == NULL) return;
  const bool heard = run_hear(r);
  if (heard && !take_reply(r, &o)) o = outcome_of(r, end);
  tell_end(r, &o);
}

void run_fail(executor_run *r, int status, const char *format, ...) {
  char text[PROBLEM_TEXT];
  problem p;
  va_list arguments;
  pool_outcome o = outcome_of(r, POOL_REPLY);
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  problem_begin(&p, status, "%s", text);
  char *bytes = problem_bytes(&p, &o.size);
  o.fd = memory_file("problem");
  o.status = status;
  if (bytes == NULL || o.fd < 0 || write(o.fd, bytes, o.size) != (ssize_t)o.size) o.size = 0;
  problem_shorten(&p, o.detail, sizeof o.detail);
  free(bytes);
  tell_end(r, &o);
}
