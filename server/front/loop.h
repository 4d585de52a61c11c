/* loop.h - the event loop of the front: descriptors to watch and chores to do in time. One thread
 * runs it; nothing in the front needs a lock but what it gives to the other one (clerk.h).
 */
#ifndef SCATTERD_LOOP_H
#define SCATTERD_LOOP_H

#include <stdbool.h>
#include <stdint.h>

typedef struct loop loop;

/* A descriptor's reader: `ready` is called with the epoll events that came. Lives in the object
 * that owns the descriptor. */
typedef struct {
  void (*ready)(void *self, uint32_t events);
  void *self;
} loop_source;

/* Something with deadlines: `due` is the time at which it wants `run` called (loop_now's clock),
 * INFINITY for never. */
typedef struct {
  double (*due)(void *self);
  void (*run)(void *self);
  void *self;
} loop_chore;

loop *loop_new(void); /* NULL with errno on failure */
void loop_free(loop **l);

/* Watches fd for `events` until loop_forget. *source must stay until then. False with errno. */
bool loop_watch(loop *l, int fd, uint32_t events, loop_source *source);

/* Stops watching; `source` is not called again, also not for events already fetched. Before the
 * descriptor is closed. */
void loop_forget(loop *l, int fd, loop_source *source);

/* Adds a chore; at most 16. */
void loop_add(loop *l, loop_chore chore);

/* Runs until loop_stop. */
void loop_run(loop *l);
void loop_stop(loop *l);

double loop_now(void); /* monotonic seconds */

/* The time of day, in seconds since 1970: as the clock tells it, but on as before when somebody has
 * set that, until unix_follow. So dates that are stored are all of one time (clock.h). */
double unix_now(void);
double unix_step(void); /* by how much (s) it has been set */
void unix_follow(void);

/* Another clock, which counts, showed `now` at some time since unix_now was `before`. Moves this
 * one by what it is wrong for certain, and returns that (s). */
double unix_tune(double now, double before);

#endif
