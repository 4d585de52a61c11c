/* frames.h - what a worker's check says of a good request (ipc_frame): whom to call, what it
 * refers to, the parts of a batch. Test: unit.frames.
 */
#ifndef SCATTERD_FRAMES_H
#define SCATTERD_FRAMES_H

#include "ipc.h"
#include "job.h"

typedef struct {
  job_part *parts; /* of a batch, offsets into the descriptor */
  int count;
  int pins;
  char pin[JOB_PINS][DATA_ID]; /* ids of the objects under /data it refers to */
  bool external;               /* it refers to other hosts, whose answer may change */
} frames;

/* Reads `size` bytes of fd; uri[k] is set for the subscriber's addresses there are. False when they
 * make no sense or memory is short; *f is to be freed either way. */
bool frames_read(int fd, size_t size, frames *f, char uri[3][JOB_URI]);
void frames_free(frames *f);

#endif
