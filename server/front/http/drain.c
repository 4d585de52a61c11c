#include "drain.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdlib.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

enum { PLACES = 64 };

static const double longest = 3; /* seconds */

typedef struct {
  drain *owner;
  int fd; /* -1: free */
  double until;
  loop_source source;
} place;

struct drain {
  loop *loop;
  place places[PLACES];
};

static void leave(place *p) {
  loop_forget(p->owner->loop, p->fd, &p->source);
  close(p->fd);
  p->fd = -1;
  p->until = INFINITY;
}

static void swallow(void *self, uint32_t events) {
  static char nowhere[65536];
  place *p = self;
  const ssize_t size = recv(p->fd, nowhere, sizeof nowhere, MSG_DONTWAIT);
  const bool later = size < 0 && (errno == EAGAIN || errno == EINTR);
  if (size <= 0 && !(later && (events & (EPOLLHUP | EPOLLERR)) == 0)) leave(p);
}

static double due(void *self) {
  const drain *g = self;
  double first = INFINITY;
  for (int k = 0; k < PLACES; k++) first = fmin(first, g->places[k].until);
  return first;
}

static void run(void *self) {
  drain *g = self;
  const double now = loop_now();
  for (int k = 0; k < PLACES; k++) {
    if (g->places[k].until <= now) leave(&g->places[k]);
  }
}

drain *drain_new(loop *l) {
  drain *g = calloc(1, sizeof *g);
  if (g == NULL) return NULL;
  g->loop = l;
  for (int k = 0; k < PLACES; k++) {
    place *p = &g->places[k];
    *p = (place){.owner = g, .fd = -1, .until = INFINITY, .source = {swallow, p}};
  }
  loop_add(l, (loop_chore){due, run, g});
  return g;
}

void drain_free(drain **g) {
  if (*g == NULL) return;
  for (int k = 0; k < PLACES; k++) {
    if ((*g)->places[k].fd >= 0) leave(&(*g)->places[k]);
  }
  free(*g);
  *g = NULL;
}

void drain_add(drain *g, int fd) {
  for (int k = 0; k < PLACES; k++) {
    place *p = &g->places[k];
    if (p->fd >= 0) continue;
    p->fd = fcntl(fd, F_DUPFD_CLOEXEC, 0);
    if (p->fd < 0) return;
    shutdown(p->fd, SHUT_WR);
    p->until = loop_now() + longest;
    if (!loop_watch(g->loop, p->fd, EPOLLIN | EPOLLRDHUP, &p->source)) leave(p);
    return;
  }
}
