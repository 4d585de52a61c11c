/* clerk.h - the front's second thread, for what takes long and needs nobody's attention: bytes that
 * are hashed, copied, fsynced. One thread does one task after the other; the loop goes on
 * meanwhile. Test: unit.clerk, http.aside.
 *
 * Nothing but the tasks given is shared, so nothing else needs a lock: `work` touches what belongs
 * to its task alone (no other object of the front; of the store only store_write_draft, which has a
 * connection of its own), and all that follows from it is done by `done`, in the loop. The log may
 * be written to: a line is one system call. Workers are forked while the thread runs; a child calls
 * nothing but what is async-signal-safe before it becomes another program (child.c).
 */
#ifndef SCATTERD_CLERK_H
#define SCATTERD_CLERK_H

#include <stdbool.h>
#include <stdint.h>

#include "fault.h"
#include "loop.h"

typedef struct clerk clerk;

/* Lives in the object that the work is about, which stays until `done` is called. */
typedef struct clerk_task {
  void (*work)(void *self); /* in the thread */
  void (*done)(void *self); /* in the loop, after it; may free *self */
  void *self;
  struct clerk_task *next; /* the clerk's */
} clerk_task;

/* Starts the thread, deaf to all signals. Tasks of fewer than `least` bytes are not for it. NULL
 * with *why. */
clerk *clerk_new(loop *l, int64_t least, fault *why);

/* After clerk_finish. */
void clerk_free(clerk **k);

/* Has a task done, which is about so many bytes: by the thread, in the order in which they come; or
 * if that is few, here and now, both of it before this returns. */
void clerk_do(clerk *k, clerk_task *t, int64_t bytes);

/* Takes back a task that has not begun: nothing of it is called any more. False if it has begun, or
 * is not with the clerk. */
bool clerk_take_back(clerk *k, clerk_task *t);

/* Waits for all tasks, then calls what is `done`. From now on all tasks, those that this brings
 * too, are done at once, by who gives them. */
void clerk_finish(clerk *k);

/* Closes a descriptor (-1: none): by the thread if that of a large file, whose bytes may go with
 * it, which takes 10 ms and more for 100 MB. */
void clerk_close(clerk *k, int fd);

/* Removes a file of a directory; the room that a large one takes is given back by the thread. Not
 * durable: who finds it again after a crash removes it again. */
void clerk_drop(clerk *k, int at, const char *name);

#endif
