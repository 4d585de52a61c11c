/* memory_file.h - files that go from process to process by their descriptors, most of them memory.
 *
 * Once sealed, a file keeps its bytes and its size for ever, whoever holds a descriptor of it: what
 * has been looked at is what will be read, and a mapping of it cannot be cut short, which would be
 * a SIGBUS to whoever reads there. Tests: unit.memory_file, http.sandbox.
 */
#ifndef SCATTERD_MEMORY_FILE_H
#define SCATTERD_MEMORY_FILE_H

#include <stdbool.h>

/* An empty one, close-on-exec, the caller's to close; -1 with errno. The name is for /proc only. */
int memory_file(const char *name);

/* Seals it, for good. False with errno, as of a descriptor of anything else. */
bool memory_file_seal(int fd);

/* Is it a memory file, and sealed? */
bool memory_file_is_sealed(int fd);

/* For files on disk, which know no seals: *fd becomes a descriptor of the same file, also of one
 * without a name, that is for reading only, at its begin. False with errno, and *fd as it was. */
bool file_reopen(int *fd);

#endif
