#include "job_queue.h"

#include <stdlib.h>
#include <string.h>

/* The waiting jobs of one submitter at one priority. Lanes of a priority form a ring in the order
 * of their turns: the first has the next one. */
typedef struct queue_lane {
  struct queue_lane *next;
  queue_node *first, *last;
  int priority;
  char submitter[];
} queue_lane;

struct job_queue {
  queue_lane *lanes[JOB_PRIORITIES];
  size_t length;
};

job_queue *job_queue_new(void) {
  return calloc(1, sizeof(job_queue));
}

static void append(queue_lane **end, queue_lane *lane) {
  while (*end != NULL) end = &(*end)->next;
  lane->next = NULL;
  *end = lane;
}

static void unlink_lane(job_queue *q, queue_lane *lane) {
  queue_lane **at = &q->lanes[lane->priority];
  while (*at != lane) at = &(*at)->next;
  *at = lane->next;
}

void job_queue_free(job_queue **q) {
  if (*q == NULL) return;
  for (int k = 0; k < JOB_PRIORITIES; k++) {
    while ((*q)->lanes[k] != NULL) {
      queue_lane *lane = (*q)->lanes[k];
      (*q)->lanes[k] = lane->next;
      free(lane);
    }
  }
  free(*q);
  *q = NULL;
}

static queue_lane *lane_of(job_queue *q, const char *submitter, int priority) {
  for (queue_lane *l = q->lanes[priority]; l != NULL; l = l->next) {
    if (strcmp(l->submitter, submitter) == 0) return l;
  }
  const size_t length = strlen(submitter);
  queue_lane *lane = calloc(1, sizeof *lane + length + 1);
  if (lane == NULL) return NULL;
  memcpy(lane->submitter, submitter, length + 1);
  lane->priority = priority;
  append(&q->lanes[priority], lane);
  return lane;
}

bool job_queue_add(job_queue *q, queue_node *node, void *owner, const char *submitter, int priority,
                   bool first) {
  queue_lane *lane = lane_of(q, submitter, priority);
  if (lane == NULL) return false;
  *node = (queue_node){.lane = lane, .owner = owner};
  node->previous = first ? NULL : lane->last;
  node->next = first ? lane->first : NULL;
  *(node->previous != NULL ? &node->previous->next : &lane->first) = node;
  *(node->next != NULL ? &node->next->previous : &lane->last) = node;
  q->length++;
  return true;
}

/* Takes a node out of its lane, which stays. */
static queue_lane *take_out(job_queue *q, queue_node *node) {
  queue_lane *lane = node->lane;
  *(node->previous != NULL ? &node->previous->next : &lane->first) = node->next;
  *(node->next != NULL ? &node->next->previous : &lane->last) = node->previous;
  node->lane = NULL;
  q->length--;
  return lane;
}

static void drop_if_empty(job_queue *q, queue_lane *lane) {
  if (lane->first != NULL) return;
  unlink_lane(q, lane);
  free(lane);
}

void job_queue_remove(job_queue *q, queue_node *node) {
  if (node->lane != NULL) drop_if_empty(q, take_out(q, node));
}

/* The turn of this lane: its oldest job goes, and the lane to the end of the ring. */
static void *serve(job_queue *q, queue_lane *lane) {
  queue_node *node = lane->first;
  take_out(q, node);
  unlink_lane(q, lane);
  append(&q->lanes[lane->priority], lane);
  drop_if_empty(q, lane);
  return node->owner;
}

void *job_queue_take(job_queue *q, bool (*fits)(void *context, void *owner), void *context) {
  for (int priority = JOB_PRIORITIES - 1; priority >= 0; priority--) {
    for (queue_lane *lane = q->lanes[priority]; lane != NULL; lane = lane->next) {
      if (fits(context, lane->first->owner)) return serve(q, lane);
      if (++lane->first->passed > JOB_PATIENCE) return NULL;
    }
  }
  return NULL;
}

size_t job_queue_length(const job_queue *q) {
  return q->length;
}
