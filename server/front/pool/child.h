/* child.h - one worker process as the front sees it: starting it, ending it.
 */
#ifndef SCATTERD_CHILD_H
#define SCATTERD_CHILD_H

#include <signal.h>
#include <stdbool.h>
#include <stdint.h>
#include <sys/types.h>

typedef struct {
  pid_t pid;  /* 0 if there is none */
  int pidfd;  /* readable when it has ended; -1 if there is none */
  int socket; /* our end, does not block; -1 when closed */
} child;

/* What all children inherit from our environment: one BLAS thread, `threads` of the library. */
void child_environment(int64_t threads);

/* Starts this program as `scatterd worker` with its end of a socket pair at IPC_SOCKET, no other
 * descriptor above standard error, at most `memory` bytes of address space (not under
 * AddressSanitizer, which needs terabytes), deaf to SIGINT and SIGTERM, and dying
 * with us. False with errno; then *c is empty. */
bool child_start(child *c, int64_t memory);

void child_kill(const child *c);

/* Waits for its end, tells how it was (waitid), and closes what is open. */
void child_reap(child *c, siginfo_t *how);

#endif
