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

/* A place in the queue; lives in what waits. All zero while it does not wait. The first node of a
 * submitter at a priority stands for all of them: there is nothing else to allocate, so that what
 * was accepted always finds its place. */
typedef struct queue_node {
  struct queue_node *next, *previous; /* of the same submitter */
  struct queue_node *turn;            /* of the first: the first of the next submitter */
  struct queue_node *last;            /* of the first: the last of them */
  void *owner;
  const char *submitter;
  int priority;
  int passed; /* times that others went first */
  bool waits;
} queue_node;

job_queue *job_queue_new(void); /* NULL when out of memory */
void job_queue_free(job_queue **q);

/* Puts `node`, which does not wait, at the end of its submitter's; `first` puts it at the start.
 * `submitter` must stay as long as it waits. Cost: the number of submitters that wait. */
void job_queue_add(job_queue *q, queue_node *node, void *owner, const char *submitter, int priority,
                   bool first);

/* Takes a node out; nothing if it does not wait. */
void job_queue_remove(job_queue *q, queue_node *node);

/* Takes out the next job that fits; NULL if none may go now. */
void *job_queue_take(job_queue *q, bool (*fits)(void *context, void *owner), void *context);

size_t job_queue_length(const job_queue *q);

#endif
