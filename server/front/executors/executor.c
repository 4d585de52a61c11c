#include "executor.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "executor_kind.h"
#include "log.h"

/* The processes that can be shared; others are for a worker, which is as good and sandboxed. */
static const char shared[] = "solve";

const executor_kind executor_local = {.name = "local", .is_here = true};
static const executor_kind *const kinds[] = {&executor_local, &executor_mpi, &executor_slurm};

/* ---- Looking ---- */

static double due(void *self) {
  const executor *x = self;
  return x->count > 0 ? x->next : INFINITY;
}

static void look(void *self) {
  executor *x = self;
  x->next = loop_now() + x->kind->seconds;
  if (x->kind->look != NULL) x->kind->look(x);
  if (x->room != NULL && executor_has_room(x)) x->room(x->room_self);
}

/* ---- The whole ---- */

/* Is a program to be found along PATH? */
static bool is_there(const char *program) {
  const char *path = getenv("PATH");
  char *copy = strdup(path != NULL ? path : "/usr/bin:/bin"), *rest = NULL;
  char file[PARAM_TEXT + 256];
  bool found = strchr(program, '/') != NULL && access(program, X_OK) == 0;
  for (char *part = copy != NULL ? strtok_r(copy, ":", &rest) : NULL; part != NULL && !found;
       part = strtok_r(NULL, ":", &rest)) {
    snprintf(file, sizeof file, "%.700s/%.500s", part, program);
    found = access(file, X_OK) == 0;
  }
  free(copy);
  return found;
}

static bool find_programs(const executor *x, fault *why) {
  char line[PARAM_TEXT];
  const char *first[1] = {""};
  const char *own = x->kind == &executor_mpi ? x->set->mpiexec : x->set->sbatch;
  snprintf(line, sizeof line, "%s", own);
  (void)command_words(line, first, 1);
  if (!is_there(first[0])) {
    return fault_set(why, "executor %s: there is no program %.200s", x->kind->name, first[0]);
  }
  for (int k = 0; x->kind->programs[k] != NULL; k++) {
    if (is_there(x->kind->programs[k])) continue;
    return fault_set(why, "executor %s: there is no program %s", x->kind->name,
                     x->kind->programs[k]);
  }
  return true;
}

/* Paths are whole ones, for programs that begin elsewhere. */
static bool find_places(executor *x, fault *why) {
  char *data = realpath(x->set->data_dir, NULL);
  const ssize_t length = readlink("/proc/self/exe", x->program, sizeof x->program - 1);
  if (data == NULL || length < 0) {
    free(data);
    return fault_set(why, "executor %s: cannot find %s: %s", x->kind->name, x->set->data_dir,
                     strerror(errno));
  }
  x->program[length] = '\0';
  snprintf(x->path, sizeof x->path, "%.*s/runs", PARAM_TEXT, data);
  free(data);
  if (mkdir(x->path, 0700) == 0 || errno == EEXIST) x->dir = run_dir_open(x->path);
  if (x->dir >= 0) return true;
  return fault_set(why, "executor %s: cannot make %.200s: %s", x->kind->name, x->path,
                   strerror(errno));
}

/* Processes of one run. */
static int64_t ranks_of(const parameters *set) {
  const long processors = sysconf(_SC_NPROCESSORS_ONLN);
  return set->limits.ranks > 0 ? set->limits.ranks : processors < 2 ? 2 : (int64_t)processors;
}

executor *executor_new(loop *l, parameters *set, fault *why) {
  executor *x = calloc(1, sizeof *x);
  if (x == NULL) {
    fault_set(why, "out of memory");
    return NULL;
  }
  x->kind = kinds[set->executor];
  x->loop = l;
  x->set = set;
  x->dir = -1;
  if (x->kind == &executor_local) {
    set->limits.ranks = 1;
    return x;
  }
  set->limits.ranks = ranks_of(set);
  x->most = set->executor_jobs > 0 ? (int)set->executor_jobs : x->kind->most;
  if (!find_programs(x, why) || !find_places(x, why)) {
    executor_free(&x);
    return NULL;
  }
  loop_add(l, (loop_chore){due, look, x});
  return x;
}

void executor_stop(executor *x) {
  command_kill(&x->asking);
  while (x->first != NULL) {
    executor_run *r = x->first;
    if (!x->kind->persists) run_finish(r, POOL_STOPPED);
    run_remove(r, !x->kind->persists);
  }
  x->most = 0;
}

void executor_free(executor **x) {
  if (*x == NULL) return;
  executor_stop(*x);
  if ((*x)->dir >= 0) close((*x)->dir);
  free(*x);
  *x = NULL;
}

/* ---- Runs ---- */

bool executor_takes(const executor *x, const char *process, int64_t points) {
  if (x->kind == &executor_local || points < x->set->limits.executor_points) return false;
  return x->kind->persists || strcmp(process, shared) == 0;
}

bool executor_is_here(const executor *x) {
  return x->kind->is_here;
}

bool executor_has_room(const executor *x) {
  return x->count < x->most;
}

void executor_on_room(executor *x, void (*room)(void *self), void *self) {
  x->room = room;
  x->room_self = self;
}

static void take_ask(executor_run *r, const ipc_ask *ask) {
  r->limit = ask->limits.seconds;
  snprintf(r->process, sizeof r->process, "%s", ask->process);
}

static bool put_request(const executor_run *r, const ipc_ask *ask, int body, int checkpoint) {
  if (!run_dir_copy(r->dir, "body", body, (size_t)ask->size)) return false;
  if (ask->checkpoint > 0 && !run_dir_copy(r->dir, "state", checkpoint, (size_t)ask->checkpoint)) {
    return false;
  }
  return run_dir_put_ask(r->dir, ask);
}

executor_run *executor_start(executor *x, const char *name, const ipc_ask *ask, int body,
                             int checkpoint, const pool_calls *calls, void *context) {
  run_dir_remove(x->dir, name); /* of an attempt before */
  if (mkdirat(x->dir, name, 0700) != 0) return NULL;
  executor_run *r = run_new(x, name, calls, context);
  if (r == NULL) return NULL;
  take_ask(r, ask);
  if (put_request(r, ask, body, checkpoint) && x->kind->start(r)) {
    x->next = loop_now() + x->kind->seconds;
    return r;
  }
  const int reason = errno;
  run_remove(r, true);
  errno = reason;
  return NULL;
}

executor_run *executor_find(executor *x, const char *name, const pool_calls *calls, void *context) {
  ipc_ask ask;
  if (!x->kind->persists) return NULL;
  executor_run *r = run_new(x, name, calls, context);
  if (r == NULL) return NULL;
  if (run_dir_get_ask(r->dir, &ask) && x->kind->find(r)) {
    take_ask(r, &ask);
    x->next = loop_now();
    return r;
  }
  run_remove(r, true);
  return NULL;
}

void executor_cancel(executor_run *r) {
  r->calls = NULL;
  r->by->kind->end(r);
}

const char *executor_place(const executor_run *r) {
  return r->place;
}

void executor_sweep(executor *x, bool (*wanted)(void *context, const char *name), void *context) {
  DIR *directory = x->dir >= 0 ? opendir(x->path) : NULL;
  if (directory == NULL) return;
  for (struct dirent *entry; (entry = readdir(directory)) != NULL;) {
    if (*entry->d_name == '.' || strlen(entry->d_name) >= sizeof x->first->name) continue;
    if (wanted(context, entry->d_name)) continue;
    executor_run *r = x->kind->persists ? executor_find(x, entry->d_name, NULL, NULL) : NULL;
    if (r != NULL) {
      executor_cancel(r);
    } else {
      run_dir_remove(x->dir, entry->d_name);
    }
  }
  closedir(directory);
}

int executor_runs(const executor *x) {
  return x->count;
}
