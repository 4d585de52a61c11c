/* job_row.h - what is stored of a job: one row of the table `jobs`.
 */
#ifndef SCATTERD_JOB_ROW_H
#define SCATTERD_JOB_ROW_H

#include <stdint.h>

#include "data_row.h"
#include "job_state.h"

enum {
  JOB_ID = 33, /* 32 hexadecimal digits and a NUL */
  JOB_PROCESS = 64,
  JOB_SUBMITTER = 64,
  JOB_MESSAGE = 240,
  JOB_KEY = 256,
  JOB_DIGEST = 65,
  JOB_URI = 1024,
  JOB_PINS = 32,
  JOB_BASE = 1100,
  JOB_HOLDER = 33,
  JOB_PHASE = 32,
};

/* Times are seconds since 1970, 0 for not yet. */
typedef struct {
  int64_t number; /* order of acceptance, > 0 */
  char id[JOB_ID];
  char process[JOB_PROCESS];
  char submitter[JOB_SUBMITTER];
  int state; /* job_state */
  int priority;
  int attempts; /* times a worker got it */
  int progress; /* per cent */
  int status;   /* failed: HTTP status of its problem */
  int content;  /* media of the request */
  int content_coding;
  int64_t size; /* bytes of the request */
  int64_t points;
  int64_t estimate;    /* bytes of memory at its peak, 0 if unknown */
  int64_t result_size; /* bytes of the stored result */
  double created, started, finished, updated;
  double expires;
  int64_t parent; /* number of the batch it is part of; 0 if of none */
  int part;       /* its place there */
  int parts;      /* a batch: how many */
  int64_t offset; /* a part: where its request begins in the file of the batch */
  int reusable;   /* its result may answer an equal request */
  int result_coding;
  int subscribed; /* its extra has addresses to call */
  char message[JOB_MESSAGE];
  char holder[JOB_HOLDER]; /* daemon that has it among several; "" for none, or the only one */
  char phase[JOB_PHASE];   /* of a running one, "" if not known */
  double residual;         /* of the iteration in that phase, 0 if not known */
} job_row;

/* What a row begins with and the rest of the daemon need not carry along. */
typedef struct {
  char key[JOB_KEY];           /* Idempotency-Key, "" without */
  char digest[JOB_DIGEST];     /* of the request */
  char uri[3][JOB_URI];        /* subscriber: success, in progress, failed; "" without */
  char pin[JOB_PINS][DATA_ID]; /* objects under /data it refers to; "" after the last */
  char base[JOB_BASE];         /* of links in what is sent there */
  int64_t jobs_most;           /* jobs its submitter may have with it, not stored; INT64_MAX: any */
} job_extra;

/* A call to a subscriber that is to be made. */
typedef struct {
  int64_t number; /* of the call */
  int64_t job;    /* number */
  int kind;       /* which address: of job_extra.uri */
  int attempts;   /* made */
  double due;
} job_call;

#endif
