/* run_dir.h - a run outside the pool: what ipc.h says over a socket stands in the files of a
 * directory, which may be shared by machines.
 *
 * front -> run: `ask` (an ipc_ask), `body`, and `state` if the ask announces a checkpoint.
 * run -> front: `news` (ipc_news, one after the other), `checkpoint`, `result`, and last of all
 * `reply` (an ipc_news). What is there under its name is complete. Test: unit.run_dir
 */
#ifndef SCATTERD_RUN_DIR_H
#define SCATTERD_RUN_DIR_H

#include "ipc.h"

/* Opens a directory; -1 with errno. */
int run_dir_open(const char *path);

/* Makes a file of some bytes, or of those of a descriptor. False with errno. */
bool run_dir_put(int dir, const char *name, const void *bytes, size_t size);
bool run_dir_copy(int dir, const char *name, int from, size_t size);

/* Opens a file for reading, with its size; -1 with errno. */
int run_dir_get(int dir, const char *name, int64_t *size);

/* A record in a file of its own; reading one fails (EPROTO) if another version wrote it. */
bool run_dir_put_ask(int dir, const ipc_ask *ask);
bool run_dir_get_ask(int dir, ipc_ask *ask);
bool run_dir_put_reply(int dir, const ipc_news *reply);
bool run_dir_get_reply(int dir, ipc_news *reply);

/* Appends to the news; takes the next one from *at on, false if there is none (yet). */
bool run_dir_tell(int dir, const ipc_news *news);
bool run_dir_hear(int dir, int64_t *at, ipc_news *news);

/* Removes the directory `name` of `at` with all files in it. */
void run_dir_remove(int at, const char *name);

#endif
