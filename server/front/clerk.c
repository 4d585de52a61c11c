#include "clerk.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/stat.h>
#include <unistd.h>

typedef struct {
  clerk_task *first, **last;
} line;

struct clerk {
  loop *loop;
  int64_t least;
  int bell; /* eventfd: readable when something is finished */
  loop_source source;
  pthread_t thread;
  bool started;
  pthread_mutex_t lock;   /* of all that follows */
  pthread_cond_t changed; /* signalled to the thread, and by it */
  line waiting, finished;
  bool working, stopped;
};

/* ---- Lines ---- */

static void line_init(line *l) {
  l->first = NULL;
  l->last = &l->first;
}

static void line_push(line *l, clerk_task *t) {
  t->next = NULL;
  *l->last = t;
  l->last = &t->next;
}

static clerk_task *line_pop(line *l) {
  clerk_task *t = l->first;
  if (t == NULL) return NULL;
  l->first = t->next;
  if (l->first == NULL) l->last = &l->first;
  return t;
}

static bool line_remove(line *l, const clerk_task *t) {
  clerk_task **at = &l->first;
  while (*at != NULL && *at != t) at = &(*at)->next;
  if (*at == NULL) return false;
  *at = t->next;
  if (t->next == NULL) l->last = at;
  return true;
}

/* ---- The thread ---- */

static void ring(const clerk *k) {
  const uint64_t one = 1;
  while (write(k->bell, &one, sizeof one) < 0 && errno == EINTR) continue;
}

/* The next task; NULL when it is to stop. */
static clerk_task *begin_next(clerk *k) {
  pthread_mutex_lock(&k->lock);
  while (k->waiting.first == NULL && !k->stopped) pthread_cond_wait(&k->changed, &k->lock);
  clerk_task *t = line_pop(&k->waiting);
  k->working = t != NULL;
  pthread_mutex_unlock(&k->lock);
  return t;
}

static void finish(clerk *k, clerk_task *t) {
  pthread_mutex_lock(&k->lock);
  k->working = false;
  line_push(&k->finished, t);
  pthread_cond_broadcast(&k->changed);
  pthread_mutex_unlock(&k->lock);
  ring(k);
}

static void *serve(void *self) {
  clerk *k = self;
  for (clerk_task *t; (t = begin_next(k)) != NULL;) {
    t->work(t->self);
    finish(k, t);
  }
  return NULL;
}

/* ---- In the loop ---- */

static clerk_task *take_finished(clerk *k) {
  pthread_mutex_lock(&k->lock);
  clerk_task *t = line_pop(&k->finished);
  pthread_mutex_unlock(&k->lock);
  return t;
}

static void tell_finished(clerk *k) {
  for (clerk_task *t; (t = take_finished(k)) != NULL;) t->done(t->self);
}

static void on_bell(void *self, uint32_t events) {
  clerk *k = self;
  uint64_t rung;
  (void)events;
  while (read(k->bell, &rung, sizeof rung) < 0 && errno == EINTR) continue;
  tell_finished(k);
}

void clerk_do(clerk *k, clerk_task *t, int64_t bytes) {
  if (bytes < k->least) {
    t->work(t->self);
    t->done(t->self);
    return;
  }
  pthread_mutex_lock(&k->lock);
  line_push(&k->waiting, t);
  pthread_cond_broadcast(&k->changed);
  pthread_mutex_unlock(&k->lock);
}

bool clerk_take_back(clerk *k, clerk_task *t) {
  pthread_mutex_lock(&k->lock);
  const bool had = line_remove(&k->waiting, t);
  pthread_mutex_unlock(&k->lock);
  return had;
}

/* Waits until the thread is at rest: what is given from then on is done here, and no two tasks at a
 * time. False if nothing is finished. */
static bool wait_for_rest(clerk *k) {
  pthread_mutex_lock(&k->lock);
  while (k->working || k->waiting.first != NULL) pthread_cond_wait(&k->changed, &k->lock);
  const bool any = k->finished.first != NULL;
  pthread_mutex_unlock(&k->lock);
  return any;
}

void clerk_finish(clerk *k) {
  k->least = INT64_MAX;
  while (wait_for_rest(k)) tell_finished(k);
}

/* ---- Large files ---- */

typedef struct {
  clerk_task task;
  int fd;
} closing;

static void close_it(void *self) {
  const closing *c = self;
  close(c->fd);
}

void clerk_close(clerk *k, int fd) {
  struct stat facts;
  const bool is_large = fd >= 0 && fstat(fd, &facts) == 0 && facts.st_size >= k->least;
  closing *c = is_large ? malloc(sizeof *c) : NULL;
  if (c == NULL) {
    if (fd >= 0) close(fd);
    return;
  }
  *c = (closing){{close_it, free, c, NULL}, fd};
  clerk_do(k, &c->task, facts.st_size);
}

void clerk_drop(clerk *k, int at, const char *name) {
  const int fd = openat(at, name, O_RDONLY | O_CLOEXEC);
  unlinkat(at, name, 0);
  clerk_close(k, fd);
}

/* ---- The whole ---- */

/* Signals are for the loop (signalfd), so the thread is born with all of them blocked. */
static int start(clerk *k) {
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  const int error = pthread_create(&k->thread, NULL, serve, k);
  pthread_sigmask(SIG_SETMASK, &before, NULL);
  k->started = error == 0;
  return error;
}

clerk *clerk_new(loop *l, int64_t least, fault *why) {
  clerk *k = calloc(1, sizeof *k);
  int error = ENOMEM;
  if (k == NULL) goto failed;
  *k = (clerk){.loop = l, .least = least};
  line_init(&k->waiting);
  line_init(&k->finished);
  pthread_mutex_init(&k->lock, NULL);
  pthread_cond_init(&k->changed, NULL);
  k->source = (loop_source){on_bell, k};
  k->bell = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  const bool watched = k->bell >= 0 && loop_watch(l, k->bell, EPOLLIN, &k->source);
  error = watched ? start(k) : errno;
  if (error == 0) return k;
failed:
  fault_set(why, "cannot start the second thread: %s", strerror(error));
  clerk_free(&k);
  return NULL;
}

static void stop(clerk *k) {
  pthread_mutex_lock(&k->lock);
  k->stopped = true;
  pthread_cond_broadcast(&k->changed);
  pthread_mutex_unlock(&k->lock);
  pthread_join(k->thread, NULL);
}

void clerk_free(clerk **k) {
  if (*k == NULL) return;
  if ((*k)->started) stop(*k);
  if ((*k)->bell >= 0) {
    loop_forget((*k)->loop, (*k)->bell, &(*k)->source);
    close((*k)->bell);
  }
  pthread_cond_destroy(&(*k)->changed);
  pthread_mutex_destroy(&(*k)->lock);
  free(*k);
  *k = NULL;
}
