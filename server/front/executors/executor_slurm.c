/* An sbatch of the same command, on a data directory that the nodes share.
 *
 * Slurm's id of a job stands in the file `slurm` of its run, so that a later daemon finds it; where
 * the daemon died between the submission and that, by the name of the job. And if it all the same
 * were submitted twice, the one that comes second would find the run taken. */
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "executor_kind.h"
#include "log.h"

static const double retry_seconds = 5; /* after a submission that failed */
static const double lost_seconds = 10; /* for files to arrive of a job that is over, or unknown */
enum { TRIES = 3, AT_ONCE = 128, NAMES = AT_ONCE * 80 };

/* ---- Submission ---- */

/* Of the job in Slurm, from that of ours. */
static void name_job(const executor_run *r, char *room, size_t size) {
  snprintf(room, size, "scatterd-%.64s", r->name);
}

static void note_id(executor_run *r, int64_t id) {
  r->id = id;
  r->is_sought = false;
  snprintf(r->place, sizeof r->place, "Slurm job %lld", (long long)id);
}

static void on_submitted(void *self, const command_end *end) {
  executor_run *r = self;
  r->command = NULL;
  const long long id = strtoll(end->output, NULL, 10);
  if (end->code == 0 && id > 0) {
    note_id(r, id);
    if (!run_dir_put(r->dir, "slurm", r->place, strlen(r->place))) {
      log_say(LOG_ERROR, "executor", "job %s: %s cannot be noted: %s", r->name, r->place,
              strerror(errno));
    }
    log_say(LOG_INFO, "submitted", "job %s is %s", r->name, r->place);
    if (r->calls == NULL) r->by->kind->end(r); /* cancelled meanwhile */
    return;
  }
  log_say(LOG_ERROR, "executor", "job %s: sbatch: %.300s", r->name, end->output);
  if (r->calls == NULL) {
    r->by->kind->end(r); /* it may have come through all the same */
  } else if (++r->tries < TRIES) {
    r->patience = loop_now() + retry_seconds;
  } else {
    run_fail(r, 503, "Slurm does not take the job: %.300s", end->output);
    run_remove(r, true);
  }
}

/* The script: paths in it are in single quotes, which nothing in a path of ours can end. */
static bool put_script(const executor_run *r) {
  const executor *x = r->by;
  char script[3 * EXECUTOR_PATH];
  if (strchr(r->path, '\'') != NULL || strchr(x->program, '\'') != NULL) {
    errno = EINVAL;
    return false;
  }
  const int length =
      snprintf(script, sizeof script,
               "#!/bin/sh\nmkdir '%s/taken' || exit 0\nexec %s -n %lld '%s' rank '%s'\n", r->path,
               x->set->mpiexec, (long long)x->set->limits.ranks, x->program, r->path);
  return run_dir_put(r->dir, "script", script, (size_t)length);
}

static bool submit(executor_run *r) {
  const executor *x = r->by;
  char line[PARAM_TEXT], name[96], option[112], ntasks[40], minutes[40];
  char output[EXECUTOR_PATH + 16], script[EXECUTOR_PATH + 8], folder[EXECUTOR_PATH + 16];
  const char *words[COMMAND_WORDS];
  snprintf(line, sizeof line, "%s", x->set->sbatch);
  int count = command_words(line, words, COMMAND_WORDS - 12);
  name_job(r, name, sizeof name);
  snprintf(option, sizeof option, "--job-name=%s", name);
  snprintf(ntasks, sizeof ntasks, "--ntasks=%lld", (long long)x->set->limits.ranks);
  snprintf(minutes, sizeof minutes, "--time=%lld", (long long)ceil(r->limit / 60));
  snprintf(output, sizeof output, "--output=%s/output", r->path);
  snprintf(folder, sizeof folder, "--chdir=%s", r->path);
  snprintf(script, sizeof script, "%s/script", r->path);
  const char *const rest[] = {"--parsable", "--no-requeue", option, ntasks, minutes,
                              output,       folder,         script, NULL};
  memcpy(words + count, rest, sizeof rest);
  r->patience = INFINITY;
  r->command = command_start(x->loop, words, -1, on_submitted, r);
  return r->command != NULL;
}

static bool start(executor_run *r) {
  snprintf(r->place, sizeof r->place, "Slurm");
  return put_script(r) && submit(r);
}

/* What an earlier daemon gave away, or was about to. */
static bool find(executor_run *r) {
  char text[EXECUTOR_PLACE] = "";
  int64_t size = 0;
  const int fd = run_dir_get(r->dir, "slurm", &size);
  if (fd >= 0) {
    if (pread(fd, text, sizeof text - 1, 0) < 0) *text = '\0';
    close(fd);
  }
  const char *number = strpbrk(text, "0123456789");
  if (number != NULL) note_id(r, strtoll(number, NULL, 10));
  r->is_sought = number == NULL;
  if (r->is_sought) snprintf(r->place, sizeof r->place, "Slurm");
  return true;
}

/* ---- States ---- */

static void begin(executor_run *r) {
  run_begin(r);
}

static void wait_on(executor_run *r) {
  (void)r;
}

static void end_as(executor_run *r, pool_end end) {
  run_finish(r, end);
  run_remove(r, true);
}

static void end_time(executor_run *r) {
  end_as(r, POOL_TIME);
}

static void end_memory(executor_run *r) {
  end_as(r, POOL_MEMORY);
}

static void end_crash(executor_run *r) {
  end_as(r, POOL_CRASH);
}

/* By somebody else: who asks for it again may submit again. */
static void end_cancelled(executor_run *r) {
  if (run_hear(r)) {
    end_crash(r);
    return;
  }
  run_fail(r, 500, "%s was cancelled in Slurm", r->place);
  run_remove(r, true);
}

/* It is over: its last files may still be on their way to us. */
static void end_soon(executor_run *r) {
  if (r->patience == INFINITY) r->patience = loop_now() + lost_seconds;
  if (r->patience <= loop_now()) end_crash(r);
}

/* Slurm's states; one that is not here is waited on. */
static const struct {
  const char *name;
  void (*act)(executor_run *r);
  bool is_over;
} states[] = {
    {"RUNNING", begin, false},           {"COMPLETING", wait_on, false},
    {"COMPLETED", end_soon, true},       {"FAILED", end_soon, true},
    {"TIMEOUT", end_time, true},         {"DEADLINE", end_time, true},
    {"OUT_OF_MEMORY", end_memory, true}, {"CANCELLED", end_cancelled, true},
    {"NODE_FAIL", end_crash, true},      {"BOOT_FAIL", end_crash, true},
    {"PREEMPTED", end_crash, true},
};

enum { STATES = sizeof states / sizeof *states };

static int state_of(const char *text) {
  int k = 0;
  while (k < STATES && strcmp(states[k].name, text) != 0) k++;
  return k;
}

/* ---- Looking ---- */

typedef struct {
  long long id;
  char state[32], name[96];
} listed;

/* The next line of squeue's output: "17|RUNNING|scatterd-...". */
static bool next_line(const char **at, listed *l) {
  while (**at != '\0') {
    const char *line = *at;
    const size_t length = strcspn(line, "\n");
    *at = line + length + (line[length] == '\n');
    char *rest;
    l->id = strtoll(line, &rest, 10);
    if (sscanf(rest, "|%31[^|\n]|%95[^\n]", l->state, l->name) == 2) return true;
  }
  return false;
}

static bool is_of(const executor_run *r, const listed *l) {
  char name[96];
  name_job(r, name, sizeof name);
  if (strcmp(l->name, name) != 0) return false;
  const int k = state_of(l->state);
  const bool is_over = k < STATES && states[k].is_over;
  return r->id > 0 ? l->id == r->id : !is_over;
}

/* One that Slurm does not know: never submitted, or over for so long that it is forgotten. */
static void act_on_unknown(executor_run *r) {
  if (r->command != NULL || (r->patience < INFINITY && r->id == 0)) return;
  if (r->is_sought) {
    r->is_sought = false;
    if (!start(r)) end_crash(r);
  } else if (r->id > 0) {
    end_soon(r);
  }
}

/* What is known of it; `is_all`: there is nothing but what the output says. */
static void act_on(executor_run *r, const char *output, bool is_all) {
  const char *at = output;
  listed l;
  while (next_line(&at, &l)) {
    if (!is_of(r, &l)) continue;
    if (r->id == 0) note_id(r, l.id);
    const int k = state_of(l.state);
    if (k == STATES || !states[k].is_over) r->patience = INFINITY;
    if (k < STATES) states[k].act(r);
    return;
  }
  if (is_all) act_on_unknown(r);
}

static void on_asked(void *self, const command_end *end) {
  executor *x = self;
  x->asking = NULL;
  if (end->code != 0) {
    if (!x->was_deaf) log_say(LOG_ERROR, "executor", "squeue: %.300s", end->output);
    x->was_deaf = true;
    return;
  }
  x->was_deaf = false;
  const bool is_all = strlen(end->output) + 1 < sizeof end->output;
  for (executor_run *r = x->first, *next; r != NULL; r = next) {
    next = r->next;
    if (r->calls != NULL && r->asked == x->question) act_on(r, end->output, is_all);
  }
  if (x->room != NULL && executor_has_room(x)) x->room(x->room_self);
}

/* Names of runs, up to AT_ONCE of them. */
typedef struct {
  char text[NAMES];
  size_t length;
  int count;
} names;

/* Adds those that were last asked for before question `since`. */
static void put_names(executor *x, unsigned since, names *n) {
  char name[96];
  for (executor_run *r = x->first; r != NULL && n->count < AT_ONCE; r = r->next) {
    if (r->calls == NULL || r->command != NULL || r->asked >= since) continue;
    name_job(r, name, sizeof name);
    n->length += (size_t)snprintf(n->text + n->length, NAMES - n->length, "%s%s",
                                  n->count++ > 0 ? "," : "", name);
    r->asked = x->question;
  }
}

/* Asks for all jobs at once; of very many for the next ones: for all before the first again. */
static void ask(executor *x) {
  names n = {.text = "--name="};
  n.length = strlen(n.text);
  x->question++;
  put_names(x, x->turn, &n);
  if (n.count < AT_ONCE) {
    x->turn = x->question;
    put_names(x, x->turn, &n);
  }
  const char *const words[] = {"squeue", "--noheader", "--states=all", "--format=%i|%T|%j",
                               n.text,   NULL};
  if (n.count > 0) x->asking = command_start(x->loop, words, -1, on_asked, x);
}

static void look(executor *x) {
  const double now = loop_now();
  for (executor_run *r = x->first, *next; r != NULL; r = next) {
    next = r->next;
    if (r->calls != NULL && run_hear(r)) {  // NOLINT(bugprone-branch-clone): in this order
      end_crash(r);                         /* its reply says how it went */
    } else if (r->calls != NULL && r->deadline <= now) {
      run_finish(r, POOL_TIME);
      x->kind->end(r);
    } else if (r->calls == NULL) {
      x->kind->end(r); /* once more, if that could not be begun */
    } else if (r->id == 0 && r->command == NULL && r->patience <= now && !submit(r)) {
      end_crash(r);
    }
  }
  if (x->asking == NULL) ask(x);
}

/* ---- The end ---- */

static void on_cancelled(void *self, const command_end *end) {
  executor_run *r = self;
  r->command = NULL;
  if (end->code != 0) {
    log_say(LOG_ERROR, "executor", "job %s: scancel: %.300s", r->name, end->output);
  }
  run_remove(r, true);
}

/* While it is being submitted that has to end first; on_submitted comes back here. So does look,
 * where no process could be had. */
static void end(executor_run *r) {
  char name[96], option[112];
  if (r->command != NULL) return;
  name_job(r, name, sizeof name);
  snprintf(option, sizeof option, "--name=%s", name);
  const char *const words[] = {"scancel", "--quiet", option, NULL};
  r->command = command_start(r->by->loop, words, -1, on_cancelled, r);
}

const executor_kind executor_slurm = {.name = "slurm",
                                      .persists = true,
                                      .most = 64,
                                      .seconds = 1,
                                      .programs = {"squeue", "scancel", NULL},
                                      .start = start,
                                      .find = find,
                                      .look = look,
                                      .end = end};
