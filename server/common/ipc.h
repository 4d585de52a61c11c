/* ipc.h - what front and worker say to each other, over a SOCK_SEQPACKET socket pair.
 *
 * front -> worker: ipc_ask with the descriptor of the body.
 * worker -> front: ipc_news: IPC_READY once, then per request any IPC_PROGRESS and one IPC_REPLY
 * with the descriptor of the reply's bytes (none when the worker ran out of memory).
 */
#ifndef SCATTERD_IPC_H
#define SCATTERD_IPC_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "limit.h"
#include "media.h"

enum { IPC_SOCKET = 3 }; /* the worker's end */

typedef struct {
  char process[64]; /* id: "solve" */
  int64_t size;     /* bytes of the body */
  media content, accept;
  coding content_coding, accept_coding;
  limits limits;
} ipc_ask;

typedef enum { IPC_READY, IPC_PROGRESS, IPC_REPLY } ipc_kind;

typedef struct {
  ipc_kind kind;
  double time;     /* PROGRESS, REPLY: when it is said (s), on the clock of both */
  char phase[32];  /* PROGRESS */
  double fraction; /* PROGRESS: 0 to 1 */
  int status;      /* REPLY: HTTP status; 0 = out of memory, no bytes */
  char type[64];   /* REPLY: media type */
  coding coding;   /* REPLY */
  int64_t size;    /* REPLY: bytes */
  int64_t points;  /* REPLY: of the cloud, 0 if there was none */
} ipc_news;

/* Sends one message, with a descriptor if fd >= 0 (the caller keeps its own copy). False with errno
 * when the other side is gone or its buffer is full and the socket does not block. */
bool ipc_send(int socket, const void *message, size_t size, int fd);

/* Receives one message of exactly `size` bytes; *fd is its descriptor (close-on-exec, the caller's
 * to close) or -1. IPC_NOTHING when none is there and the socket does not block, IPC_GONE when the
 * other side closed, died or sent anything else. */
typedef enum { IPC_MESSAGE, IPC_NOTHING, IPC_GONE } ipc_result;
ipc_result ipc_receive(int socket, void *message, size_t size, int *fd);

#endif
