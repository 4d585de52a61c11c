/* limit.h - what one request may use. Values come from the parameter table (param.c). */
#ifndef SCATTERD_LIMIT_H
#define SCATTERD_LIMIT_H

#include <stdint.h>

typedef struct {
  int64_t body_bytes;       /* as sent */
  int64_t decoded_bytes;    /* after Content-Encoding */
  int64_t depth;            /* nesting of a body */
  int64_t nodes;            /* values of a body, an array of numbers being one */
  int64_t points;           /* of a cloud */
  int64_t neighbours;       /* of one point */
  int64_t expression_bytes; /* of one expression */
  int64_t expression_work;  /* operations of one expression times points */
  int64_t steps;            /* of a time-dependent solve */
  int64_t memory_bytes;     /* of a worker */
  double seconds;           /* of a solve */
  int64_t threads;          /* of a worker */
  int64_t ranks;            /* processes that share a large job; 1: jobs are not shared */
  int64_t executor_points;  /* from which a job is large */
} limits;

#endif
