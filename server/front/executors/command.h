/* command.h - other programs, run beside the event loop.
 *
 * Each is the head of a process group of its own, with nothing of ours open, and dies with us.
 * Test: http.executor_mpi, http.executor_slurm, http.executor_commands (stand-ins)
 */
#ifndef SCATTERD_COMMAND_H
#define SCATTERD_COMMAND_H

#include <stdbool.h>
#include <stddef.h>

#include "loop.h"

typedef struct command command;

typedef struct {
  int code;           /* exit status; -1: ended by a signal */
  char output[32768]; /* what it wrote, as far as that fits; "" if it went to a file */
} command_end;

/* Starts argv[0], found along PATH; NULL with errno. What it writes goes to descriptor `output`, or
 * is kept for `ended` if that is -1. `ended` is called once, from the loop, and the command is gone
 * when it returns. A program that cannot be started ends with code 127. */
command *command_start(loop *l, const char *const argv[], int output,
                       void (*ended)(void *self, const command_end *end), void *self);

/* Sends a signal to its group. */
void command_signal(const command *c, int signal);

/* Kills it, waits for its end, and forgets it without a call of `ended`. */
void command_kill(command **c);

enum { COMMAND_WORDS = 64 };

/* Cuts `line` at blanks, in place, into at most `room` words; returns how many. */
int command_words(char *line, const char *words[], int room);

#endif
