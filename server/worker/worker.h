/* worker.h - the worker process: receives a request, answers it, sends the reply, again and again.
 */
#ifndef SCATTERD_WORKER_H
#define SCATTERD_WORKER_H

#include "answer.h"

/* The loop, on socket IPC_SOCKET. Returns the exit status: 0 when the front closes the socket, 2
 * when there is no front. */
int worker_main(void);

/* One request without a front: `scatterd run`. Reads the file `path` ("-" is standard input), whose
 * media type its ending tells (.cbor, else JSON), and writes the result to `out` (NULL or "-" is
 * standard output) in the form its ending tells (.cbor, .npy, .csv, .vtp), or the problem to
 * standard error. Inputs by reference are files beside the request. Returns the exit status: 0
 * result, 1 problem, 2 a file could not be read or written. */
int worker_run(const char *process, const char *path, const char *out, const limits *bounds);

#endif
