/* check.h - what the check of a request tells: frames for who will store and run it (ipc.h).
 * Proof: unit.check
 */
#ifndef SCATTERD_CHECK_H
#define SCATTERD_CHECK_H

#include "grow.h"
#include "perform.h"

/* Writes the frames of a request that was read and found good: who is to be called, what will be
 * fetched, children. False with t->error set when out of memory. */
bool check_frames(task *t, const performance *f, grow_bytes *frames);

/* Appends one frame: a head and its bytes. */
bool check_put(task *t, const ipc_frame *head, const void *bytes, grow_bytes *frames);

#endif
