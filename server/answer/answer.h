/* answer.h - one request, from body to reply: decode, check, solve, encode.
 *
 * This is all a worker does; `scatterd run` calls it without a server. It touches no socket and
 * no file: what it needs from outside it asks its caller for (ask_calls).
 */
#ifndef SCATTERD_ANSWER_H
#define SCATTERD_ANSWER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ipc.h"

/* A value by reference, as its caller got it. */
typedef struct {
  int status; /* 200, or what the client is told */
  const void *bytes;
  size_t size;
  media media;
  coding coding;
  char output[IPC_NAME]; /* the bytes are a stored result, this output of it is meant */
  char detail[512];      /* why there is none */
} ask_fetched;

/* Where a value can be had from now on. */
typedef struct {
  int status; /* 200, or what the client is told */
  char href[IPC_URL];
  char detail[512]; /* why it is not kept */
} ask_kept;

/* What the caller does for an answer; NULL members: nobody does. */
typedef struct {
  void *context;
  bool (*report)(void *context, const char *phase, double fraction); /* of the whole request */
  void (*residual)(void *context, double value); /* of the newest step of an iteration */
  void (*fetch)(void *context, const char *href, ask_fetched *out);
  void (*release)(void *context, ask_fetched *out); /* after each fetch */
  void (*keep)(void *context, const char *type, const void *bytes, size_t size, ask_kept *out);
  bool (*checkpoint)(void *context, const void *bytes, size_t size);
} ask_calls;

typedef struct {
  ipc_work work;
  const char *process;     /* id: "solve" */
  const char *output;      /* RENDER: NULL or "": the whole document */
  const char *results_url; /* RENDER */
  const void *body;
  size_t size;
  media content; /* of the body */
  coding content_coding;
  wishes accept; /* for the result */
  coding accept_coding;
  const limits *limits;
  const void *checkpoint; /* RUN_STORED: NULL: starts afresh */
  size_t checkpoint_size;
  struct by_ranks *ranks; /* RUN_STORED: by_ranks.h; NULL: this process only */
  ask_calls calls;
} ask;

typedef struct {
  int status;     /* HTTP status */
  char type[128]; /* media type of the bytes */
  coding coding;  /* of the bytes */
  void *bytes;    /* malloc'ed; NULL only when out of memory */
  size_t size;
  int64_t points;       /* of the cloud, 0 if there was none; for the log */
  int64_t memory_bytes; /* estimated peak, 0 if unknown */
  char detail[200];     /* of a problem, as far as it fits; for the state of a job */
} reply;

/* Not a process: its body is to be kept under /data. CHECK reads it through, RUN also gives it back
 * without its content coding. */
#define ANSWER_DATA "data"

/* Takes what answers will keep for good; a worker calls it once, before anything else. */
void answer_prepare(void);

/* Answers. Never fails: what goes wrong is a problem document in the reply. The caller frees
 * reply->bytes. */
void answer(const ask *ask, reply *reply);

/* ---- Several processes, started together by mpiexec, that answer one request ---- */

typedef struct by_ranks by_ranks;

/* What a process has to do with the reply, after answer(): give it; leave without a word; give it
 * and end at once, for it cannot go on with the others, who wait for it. */
typedef enum { ANSWER_REPLIES, ANSWER_LEAVES, ANSWER_STUCK } answer_role;

/* This process among them; alone if nobody started it together with others. NULL: no memory. */
by_ranks *answer_ranks_new(void);
int answer_ranks_place(const by_ranks *r); /* 0 to their number - 1 */
answer_role answer_ranks_role(const by_ranks *r);

/* Waits for the others, if they were joined. */
void answer_ranks_free(by_ranks **r);

#endif
