/* `mpiexec -n N scatterd rank DIRECTORY` on this machine, as a group of processes that dies with
 * us. */
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "executor_kind.h"
#include "log.h"

static const double patience_seconds = 0.4; /* between SIGTERM and SIGKILL */

/* The end of what the processes wrote, for the log. */
static void log_output(const executor_run *r) {
  char text[1024] = "";
  int64_t size = 0;
  const int fd = run_dir_get(r->dir, "output", &size);
  if (fd < 0) return;
  const off_t from = size > (int64_t)sizeof text - 1 ? (off_t)size - (off_t)sizeof text + 1 : 0;
  const ssize_t got = pread(fd, text, sizeof text - 1, from);
  close(fd);
  if (got > 0) text[got] = '\0';
  for (char *at = text; *at != '\0'; at++) {
    if (*at == '\n') *at = ' ';
  }
  log_say(LOG_ERROR, "executor", "job %s: %s", r->name, text);
}

static void on_ended(void *self, const command_end *end) {
  executor_run *r = self;
  executor *x = r->by;
  r->command = NULL;
  const bool is_out_of_time = r->deadline <= loop_now();
  if (end->code != 0 && r->calls != NULL && !is_out_of_time && !run_hear(r)) log_output(r);
  run_finish(r, is_out_of_time ? POOL_TIME : POOL_CRASH);
  run_remove(r, true);
  if (x->room != NULL && executor_has_room(x)) x->room(x->room_self);
}

static bool start(executor_run *r) {
  const executor *x = r->by;
  char line[PARAM_TEXT], ranks[24];
  const char *words[COMMAND_WORDS];
  snprintf(line, sizeof line, "%s", x->set->mpiexec);
  int count = command_words(line, words, COMMAND_WORDS - 6);
  snprintf(ranks, sizeof ranks, "%lld", (long long)x->set->limits.ranks);
  const char *const rest[] = {"-n", ranks, x->program, "rank", r->path, NULL};
  memcpy(words + count, rest, sizeof rest);
  const int output = openat(r->dir, "output", O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
  if (output < 0) return false;
  r->command = command_start(x->loop, words, output, on_ended, r);
  close(output);
  if (r->command == NULL) return false;
  r->deadline = loop_now() + r->limit; /* starting up counts */
  return true;
}

/* Asks it to end, then makes it. */
static void end(executor_run *r) {
  if (r->patience < INFINITY) return;
  command_signal(r->command, SIGTERM);
  r->patience = loop_now() + patience_seconds;
}

static void look(executor *x) {
  const double now = loop_now();
  for (executor_run *r = x->first; r != NULL; r = r->next) {
    (void)run_hear(r);
    if (r->deadline <= now) end(r);
    if (r->patience <= now) command_signal(r->command, SIGKILL);
  }
}

const executor_kind executor_mpi = {.name = "mpi",
                                    .is_here = true,
                                    .most = 1,
                                    .seconds = 0.2,
                                    .start = start,
                                    .look = look,
                                    .end = end};
