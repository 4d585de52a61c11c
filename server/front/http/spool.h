/* spool.h - where a body goes as it arrives: a memory file, and above a size a file in a directory
 * that has no name, so that nothing is left whatever happens. Test: unit.spool.
 */
#ifndef SCATTERD_SPOOL_H
#define SCATTERD_SPOOL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct {
  int fd;       /* -1 while empty */
  int64_t size; /* bytes so far */
  bool on_disk;
} spool;

#define SPOOL_EMPTY \
  (spool) {         \
    .fd = -1        \
  }

/* Appends bytes; the spool moves to `directory` when it grows above `memory` bytes. False with
 * errno (ENOSPC, EMFILE, ...). */
bool spool_add(spool *s, const void *bytes, size_t size, int64_t memory, const char *directory);

/* Its descriptor, from now on the caller's; -1 if it is empty. The size is still known. */
int spool_take(spool *s);

/* The spool is whole: a file on disk is from here on open for reading only. One in memory is
 * sealed when a worker gets it (worker_send). False with errno. */
bool spool_end(spool *s);

void spool_close(spool *s);

#endif
