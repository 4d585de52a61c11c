/* ipc.h - what front and worker say to each other, over a SOCK_SEQPACKET socket pair.
 *
 * front -> worker: ipc_ask with the descriptor of the body; if it announces a checkpoint, an
 * ipc_given with the descriptor of that follows at once.
 * worker -> front: ipc_news: IPC_READY once; then per ask any IPC_PROGRESS, IPC_CHECKPOINT,
 * IPC_FETCH and IPC_KEEP, and one IPC_REPLY with the descriptor of the reply's bytes (none when the
 * worker ran out of memory). Bytes come from a worker in sealed memory files only (memory_file.h),
 * so what the front has looked at stays as it is. front -> worker: one ipc_given for each IPC_FETCH
 * and IPC_KEEP, for which the worker waits.
 *
 * The works:
 *   RUN         body in, reply out in the form the client wants
 *   RUN_STORED  the run of a job: the reply is a stored result, one CBOR document that keeps all
 *               requested outputs at full precision, response mode and transmission modes
 *   CHECK       decodes and checks the body only: status 200 and ipc_frames when it is good (see
 *               there), else the problem; the reply says `points` and `memory_bytes`
 *   RENDER      body is a stored result: replies as GET {results_url}[/{output}] must
 *
 * A reply of RUN or RENDER with status 204 (response raw, transmission by reference) has as bytes
 * the values of Link fields, one a line.
 */
#ifndef SCATTERD_IPC_H
#define SCATTERD_IPC_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "limit.h"
#include "media.h"

enum { IPC_SOCKET = 3 /* the worker's end */, IPC_NAME = 64, IPC_URL = 1280 };

typedef enum { IPC_RUN, IPC_RUN_STORED, IPC_CHECK, IPC_RENDER } ipc_work;

typedef struct {
  ipc_work work;
  char process[IPC_NAME];    /* id: "solve" */
  char output[IPC_NAME];     /* RENDER: the one output wanted, "" = the results document */
  char results_url[IPC_URL]; /* RENDER: "{B}/jobs/ID/results", what references point into */
  char base[IPC_URL];        /* RUN: {B}, before the href of a kept value */
  char owner[IPC_NAME];      /* whose values it may refer to; "" without tokens; for the front */
  int64_t size;              /* bytes of the body */
  media content;             /* of the body */
  wishes accept;             /* for the reply; nothing wished: JSON */
  coding content_coding, accept_coding;
  limits limits;
  int64_t checkpoint; /* RUN_STORED: bytes of the checkpoint that follows; 0: there is none */
} ipc_ask;

typedef enum {
  IPC_READY,
  IPC_PROGRESS,   /* phase, fraction */
  IPC_CHECKPOINT, /* size and descriptor of a state from which a later run can go on */
  IPC_FETCH,      /* href: a value by reference is needed, answered by ipc_given */
  IPC_KEEP,       /* type, size and descriptor of a value to be kept, answered by ipc_given */
  IPC_REPLY
} ipc_kind;

typedef struct {
  ipc_kind kind;
  double time;          /* PROGRESS, REPLY: when it is said (s), on the clock of both */
  char phase[32];       /* PROGRESS */
  double fraction;      /* PROGRESS: 0 to 1, of the whole request */
  double residual;      /* PROGRESS: of an iteration, 0 if nothing new is known of one */
  char href[IPC_URL];   /* FETCH: as the client wrote it */
  int status;           /* REPLY: HTTP status; 0 = out of memory, no bytes */
  char type[128];       /* REPLY, KEEP: media type, with parameters where it needs them */
  coding coding;        /* REPLY */
  int64_t size;         /* REPLY, CHECKPOINT, KEEP: bytes */
  int64_t points;       /* REPLY: of the cloud, 0 if there was none */
  int64_t memory_bytes; /* REPLY: estimated peak of the run, 0 if unknown */
  char detail[200];     /* REPLY: what its problem says, as far as it fits */
} ipc_news;

/* What the front gives: with a descriptor when status is 200, else with the reason in `detail`. */
typedef struct {
  int status;            /* 200 here it is (KEEP: it is kept); else the status for the client */
  int64_t size;          /* FETCH, checkpoint: bytes */
  media media;           /* FETCH */
  coding coding;         /* FETCH */
  char output[IPC_NAME]; /* FETCH: the bytes are a stored result, the value is this output of it */
  char href[IPC_URL];    /* KEEP: where it is, "/data/ID" */
  char detail[512];      /* subject, got, needed */
} ipc_given;

/* The reply to CHECK is any number of frames, each an ipc_frame and then `size` bytes, nothing
 * between (so frames are not aligned: copy them out). */
typedef enum {
  IPC_FRAME_SUCCESS,     /* bytes: subscriber.successUri */
  IPC_FRAME_IN_PROGRESS, /* subscriber.inProgressUri */
  IPC_FRAME_FAILED,      /* subscriber.failedUri */
  IPC_FRAME_HREF,        /* bytes: an href the run will fetch, to be pinned */
  IPC_FRAME_CHILD        /* bytes: CBOR body of a child of a batch, in order; the fields below */
} ipc_frame_kind;

typedef struct {
  ipc_frame_kind kind;
  char process[IPC_NAME]; /* CHILD */
  int64_t size;           /* bytes that follow */
  int64_t points;         /* CHILD */
  int64_t memory_bytes;   /* CHILD */
} ipc_frame;

/* Sends one message, with a descriptor if fd >= 0 (the caller keeps its own copy). False with errno
 * when the other side is gone or its buffer is full and the socket does not block. */
bool ipc_send(int socket, const void *message, size_t size, int fd);

/* Receives one message of exactly `size` bytes; *fd is its descriptor (close-on-exec, the caller's
 * to close) or -1. IPC_NOTHING when none is there and the socket does not block, IPC_GONE when the
 * other side closed, died or sent anything else. */
typedef enum { IPC_MESSAGE, IPC_NOTHING, IPC_GONE } ipc_result;
ipc_result ipc_receive(int socket, void *message, size_t size, int *fd);

#endif
