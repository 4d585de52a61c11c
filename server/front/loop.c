#include "loop.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <sys/epoll.h>
#include <time.h>
#include <unistd.h>

enum { CHORES = 16, BATCH = 64 };

struct loop {
  int epoll;
  bool stopped;
  int chores;
  loop_chore chore[CHORES];
  int fetched; /* events of this round */
  struct epoll_event event[BATCH];
};

static double read_clock(clockid_t which) {
  struct timespec t;
  clock_gettime(which, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

double loop_now(void) {
  return read_clock(CLOCK_MONOTONIC);
}

/* Of the time of day to the time since boot, which counts what a machine sleeps: a result may
 * expire while nobody is awake. */
static double offset;
static bool is_followed;

static double offset_of_clock(void) {
  return read_clock(CLOCK_REALTIME) - read_clock(CLOCK_BOOTTIME);
}

void unix_follow(void) {
  offset = offset_of_clock();
  is_followed = true;
}

double unix_now(void) {
  if (!is_followed) unix_follow();
  return offset + read_clock(CLOCK_BOOTTIME);
}

double unix_tune(double now, double before) {
  const double after = unix_now(), by = now - (before + after) / 2;
  if (fabs(by) <= (after - before) / 2) return 0;
  offset += by;
  return by;
}

double unix_step(void) {
  return is_followed ? offset_of_clock() - offset : 0;
}

loop *loop_new(void) {
  loop *l = calloc(1, sizeof *l);
  if (l == NULL) return NULL;
  l->epoll = epoll_create1(EPOLL_CLOEXEC);
  if (l->epoll < 0) {
    free(l);
    return NULL;
  }
  return l;
}

void loop_free(loop **l) {
  if (*l == NULL) return;
  close((*l)->epoll);
  free(*l);
  *l = NULL;
}

bool loop_watch(loop *l, int fd, uint32_t events, loop_source *source) {
  struct epoll_event event = {.events = events, .data.ptr = source};
  return epoll_ctl(l->epoll, EPOLL_CTL_ADD, fd, &event) == 0;
}

void loop_forget(loop *l, int fd, loop_source *source) {
  epoll_ctl(l->epoll, EPOLL_CTL_DEL, fd, NULL);
  for (int k = 0; k < l->fetched; k++) {
    if (l->event[k].data.ptr == source) l->event[k].data.ptr = NULL;
  }
}

void loop_add(loop *l, loop_chore chore) {
  if (l->chores == CHORES) abort();
  l->chore[l->chores++] = chore;
}

/* Milliseconds until the next chore, rounded up so that it is due then; -1 for no chore. */
static int patience(const loop *l) {
  double due = INFINITY;
  for (int k = 0; k < l->chores; k++) due = fmin(due, l->chore[k].due(l->chore[k].self));
  if (due == INFINITY) return -1;
  const double wait = ceil(1e3 * (due - loop_now()));
  return wait <= 0 ? 0 : wait < 3.6e6 ? (int)wait : 3600000;
}

static void run_chores(loop *l) {
  for (int k = 0; k < l->chores; k++) {
    const double due = l->chore[k].due(l->chore[k].self);
    if (due <= loop_now()) l->chore[k].run(l->chore[k].self); /* the clock is read after due */
  }
}

void loop_run(loop *l) {
  l->stopped = false;
  while (!l->stopped) {
    l->fetched = epoll_wait(l->epoll, l->event, BATCH, patience(l));
    if (l->fetched < 0 && errno != EINTR) abort(); /* only a bug makes it fail */
    for (int k = 0; k < l->fetched; k++) {
      loop_source *source = l->event[k].data.ptr;
      if (source != NULL) source->ready(source->self, l->event[k].events);
    }
    l->fetched = 0;
    run_chores(l);
  }
}

void loop_stop(loop *l) {
  l->stopped = true;
}
