/* keep.h - files that are there for good once they are there: written under another name, fsynced,
 * renamed, directory fsynced. Test: unit.keep.
 */
#ifndef SCATTERD_KEEP_H
#define SCATTERD_KEEP_H

#include <stdbool.h>
#include <stddef.h>

/* Writes the first `size` bytes of descriptor `from` (its offset does not matter) as file `name` of
 * the directory `at`. False with errno (ENOSPC, EIO, ...); then there is no such file. Cost: two
 * fsyncs. */
bool keep_file(int at, const char *name, int from, size_t size);

/* The same with a descriptor of its own (-1: none), which is closed here, since with a large memory
 * file that takes a while, too, and is -1 then. 0 or an errno. */
int keep_taken(int at, const char *name, int *from, size_t size);

/* A second name for a file of the directory, durable as well. */
bool keep_link(int at, const char *name, const char *other);

/* Opens a kept file for reading; -1 with errno. */
int keep_open(int at, const char *name);

/* Drops all files of the directory that `wanted` does not want. */
void keep_sweep(int at, bool (*wanted)(void *context, const char *name), void *context);

#endif
