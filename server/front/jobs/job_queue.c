#include "job_queue.h"

#include <stdlib.h>
#include <string.h>

struct job_queue {
  queue_node *turns[JOB_PRIORITIES]; /* a ring: the submitter of the first has the next turn */
  size_t length;
};

job_queue *job_queue_new(void) {
  return calloc(1, sizeof(job_queue));
}

void job_queue_free(job_queue **q) {
  free(*q);
  *q = NULL;
}

/* Where the ring refers to the first node of a submitter; its end if there is none. */
static queue_node **place_of(job_queue *q, const char *submitter, int priority) {
  queue_node **at = &q->turns[priority];
  while (*at != NULL && strcmp((*at)->submitter, submitter) != 0) at = &(*at)->turn;
  return at;
}

static void add_last(queue_node *head, queue_node *node) {
  node->previous = head->last;
  head->last->next = node;
  head->last = node;
}

/* Before the first of its submitter, if there is one, in whose place it stands then. */
static void add_first(queue_node **at, queue_node *node) {
  queue_node *head = *at;
  node->last = head != NULL ? head->last : node;
  node->turn = head != NULL ? head->turn : NULL;
  node->next = head;
  if (head != NULL) head->previous = node;
  *at = node;
}

void job_queue_add(job_queue *q, queue_node *node, void *owner, const char *submitter, int priority,
                   bool first) {
  queue_node **at = place_of(q, submitter, priority);
  *node = (queue_node){.owner = owner, .submitter = submitter, .priority = priority, .waits = true};
  if (first || *at == NULL) {
    add_first(at, node);
  } else {
    add_last(*at, node);
  }
  q->length++;
}

/* Takes out the first of its submitter: the next one stands in its place. */
static void remove_first(queue_node **at) {
  queue_node *node = *at, *head = node->next;
  *at = head != NULL ? head : node->turn;
  if (head == NULL) return;
  head->previous = NULL;
  head->turn = node->turn;
  head->last = node->last;
}

static void remove_later(queue_node *head, queue_node *node) {
  node->previous->next = node->next;
  *(node->next != NULL ? &node->next->previous : &head->last) = node->previous;
}

void job_queue_remove(job_queue *q, queue_node *node) {
  if (!node->waits) return;
  queue_node **at = place_of(q, node->submitter, node->priority);
  if (*at == NULL) return; /* cannot be: who waits is in there */
  if (node == *at) {
    remove_first(at);
  } else {
    remove_later(*at, node);
  }
  node->waits = false;
  q->length--;
}

/* The turn of a submitter: its oldest job goes, and the submitter to the end of the ring. */
static void *serve(job_queue *q, queue_node *node) {
  queue_node *next = node->next;
  job_queue_remove(q, node);
  if (next != NULL) {
    *place_of(q, next->submitter, next->priority) = next->turn;
    next->turn = NULL;
    *place_of(q, next->submitter, next->priority) = next;
  }
  return node->owner;
}

void *job_queue_take(job_queue *q, bool (*fits)(void *context, void *owner), void *context) {
  for (int priority = JOB_PRIORITIES - 1; priority >= 0; priority--) {
    for (queue_node *first = q->turns[priority]; first != NULL; first = first->turn) {
      if (fits(context, first->owner)) return serve(q, first);
      if (++first->passed > JOB_PATIENCE) return NULL;
    }
  }
  return NULL;
}

size_t job_queue_length(const job_queue *q) {
  return q->length;
}
