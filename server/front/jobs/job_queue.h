/* job_queue.h - which waiting job is next: the highest priority first; within one, the submitters
 * take turns, each with its oldest job, so that thousands of jobs of one do not delay the single
 * one of another. A job that does not fit now (memory) lets others pass, but only so many times:
 * then everybody waits until it fits. Test: unit.job_queue.
 */
#ifndef SCATTERD_JOB_QUEUE_H
#define SCATTERD_JOB_QUEUE_H

#include <stdbool.h>
#include <stddef.h>

enum { JOB_PRIORITIES = 10 /* 0 to 9, 9 first */, JOB_PRIORITY = 5, JOB_PATIENCE = 32 };

typedef struct job_queue job_queue;

/* A place in the queue; lives in what waits. All zero while it does not wait. */
typedef struct queue_node {
  struct queue_node *next, *previous;
  struct queue_lane *lane;
  void *owner;
  int passed; /* times that others went first */
} queue_node;

job_queue *job_queue_new(void); /* NULL when out of memory */
void job_queue_free(job_queue **q);

/* Puts `node`, which does not wait, at the end of its submitter's; `first` puts it at the start.
 * False when out of memory. Cost: the number of submitters that wait. */
bool job_queue_add(job_queue *q, queue_node *node, void *owner, const char *submitter, int priority,
                   bool first);

/* Takes a node out; nothing if it does not wait. */
void job_queue_remove(job_queue *q, queue_node *node);

/* Takes out the next job that fits; NULL if none may go now. */
void *job_queue_take(job_queue *q, bool (*fits)(void *context, void *owner), void *context);

size_t job_queue_length(const job_queue *q);

#endif
