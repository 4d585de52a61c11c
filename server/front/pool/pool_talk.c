/* The messages with a worker: what it is given, what is made of what it says. */
#include <math.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "counter.h"
#include "memory_file.h"
#include "pool_worker.h"

bool worker_send(worker *w, const void *message, size_t size, int fd) {
  if (fd >= 0) (void)memory_file_seal(fd); /* in vain on disk, where all are for reading only */
  return ipc_send(w->child.socket, message, size, fd);
}

bool worker_give(worker *w, pool_task *t) {
  t->started = loop_now(); /* before, as the worker may be done when the send returns */
  if (!worker_send(w, &t->ask, sizeof t->ask, t->body)) return false;
  counter_observe(COUNTER_WAIT_SECONDS, t->started - t->submitted, NO_LABELS);
  w->task = t;
  w->pool->jobs += t->is_job;
  worker_become(w, BUSY, t->ask.limits.seconds);
  return true;
}

/* ---- What workers say ---- */

/* Is there a file of so many bytes, which will stay what it is whatever the worker does next? */
static bool has_bytes(int fd, int64_t size) {
  struct stat facts;
  return fd >= 0 && size >= 0 && memory_file_is_sealed(fd) && fstat(fd, &facts) == 0 &&
         facts.st_size >= size;
}

/* Is it a media type of ours? What is kept is served as that, and a page would run in a browser. */
static bool is_plain(const char *type) {
  media known;
  return media_find(type, &known);
}

/* Could an honest worker say this of its reply? */
static bool makes_sense(const ipc_news *news) {
  return news->status >= 200 && news->status <= 599 && news->coding < CODING_COUNT &&
         news->points >= 0 && news->memory_bytes >= 0;
}

/* A reply came. False if it is not one. */
static bool take_reply(worker *w, const ipc_news *news, int fd) {
  pool_outcome outcome = {.end = POOL_MEMORY, .fd = -1};
  if (w->state != BUSY) return false;
  if (news->status != 0) {
    if (!has_bytes(fd, news->size) || !makes_sense(news)) return false;
    outcome = (pool_outcome){.end = POOL_REPLY,
                             .status = news->status,
                             .coding = news->coding,
                             .fd = fd,
                             .size = (size_t)news->size,
                             .points = news->points,
                             .memory_bytes = news->memory_bytes};
    memcpy(outcome.type, news->type, sizeof outcome.type - 1);
    memcpy(outcome.detail, news->detail, sizeof outcome.detail - 1);
  } else if (fd >= 0) {
    return false;
  }
  w->served++;
  w->failures = 0;
  task_enter_phase(w->task, "", news->time);
  worker_finish(w, &outcome);
  worker_become_idle(w);
  return true;
}

static bool take_ready(worker *w, const ipc_news *news, int fd) {
  (void)news;
  if (fd >= 0 || w->state != STARTING) return false;
  worker_become_idle(w);
  return true;
}

static bool take_progress(worker *w, const ipc_news *news, int fd) {
  pool_task *t = w->task;
  if (fd >= 0 || w->state != BUSY) return false;
  ipc_news sane = *news;
  sane.fraction = fmin(1, fmax(0, news->fraction)); /* 0 for what is no number */
  task_enter_phase(t, news->phase, news->time);
  if (t->calls->heard != NULL) t->calls->heard(t->context, &sane, -1);
  return true;
}

/* Each is a file that the front waits for, so one that comes too soon is not kept. */
static bool take_checkpoint(worker *w, const ipc_news *news, int fd) {
  static const double pause = 1; /* honest workers make one in two seconds */
  pool_task *t = w->task;
  if (w->state != BUSY || !has_bytes(fd, news->size)) return false;
  const double now = loop_now();
  if (t->calls->heard != NULL && now >= t->saved + pause) {
    t->saved = now;
    t->calls->heard(t->context, news, fd);
  } else {
    close(fd);
  }
  return true;
}

static bool take_wish(worker *w, const ipc_news *news, int fd) {
  static const ipc_given nobody = {.status = 400, .detail = "values by reference are not served"};
  const pool_values *v = &w->pool->values;
  if (w->state != BUSY || (news->kind == IPC_KEEP) != (fd >= 0)) return false;
  if (fd >= 0 && (!has_bytes(fd, news->size) || !is_plain(news->type))) return false;
  if (w->task->wishes) return false; /* it should wait */
  w->task->wishes = true;
  if (v->wanted != NULL) {
    v->wanted(v->self, w->task, news, fd);
  } else {
    if (fd >= 0) close(fd);
    pool_give(w->pool, w->task, &nobody, -1);
  }
  return true;
}

/* What comes is acted upon, or false: it makes no sense now. */
static bool (*const takes[])(worker *w, const ipc_news *news, int fd) = {
    [IPC_READY] = take_ready, [IPC_PROGRESS] = take_progress, [IPC_CHECKPOINT] = take_checkpoint,
    [IPC_FETCH] = take_wish,  [IPC_KEEP] = take_wish,         [IPC_REPLY] = take_reply,
};

static bool take(worker *w, ipc_news *news, int fd) {
  if ((size_t)news->kind >= sizeof takes / sizeof *takes) return false;
  news->phase[sizeof news->phase - 1] = '\0';
  news->href[sizeof news->href - 1] = '\0';
  news->type[sizeof news->type - 1] = '\0';
  return takes[news->kind](w, news, fd);
}

void worker_listen(worker *w, int most) {
  ipc_news news;
  int fd;
  for (int k = 0; k < most && w->child.socket >= 0; k++) {
    const ipc_result result = ipc_receive(w->child.socket, &news, sizeof news, &fd);
    if (result == IPC_NOTHING) return;
    if (result == IPC_MESSAGE && take(w, &news, fd)) continue;
    if (result == IPC_MESSAGE && fd >= 0) close(fd);
    worker_kill(w); /* gone, or to be; on_exited does the rest */
  }
}
