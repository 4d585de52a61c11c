#include "metrics.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <time.h>
#include <unistd.h>

#include "counter.h"
#include "loop.h"
#include "media.h"
#include "negotiate.h"
#include "ready.h"

/* ---- Requests ---- */

static const char *method_of(const exchange *x) {
  static const char *const known[] = {"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"};
  for (size_t k = 0; k < sizeof known / sizeof *known; k++) {
    if (strcmp(known[k], x->method) == 0) return known[k];
  }
  return "other";
}

void metrics_count(const exchange *x, const char *route) {
  char status[16] = "aborted";
  if (x->reply.status != 0) snprintf(status, sizeof status, "%d", x->reply.status);
  counter_add(COUNTER_REQUESTS, 1, LABELS(route, method_of(x), status));
  counter_observe(COUNTER_REQUEST_SECONDS, loop_now() - x->began, LABELS(route));
  counter_add(COUNTER_BYTES_IN, (double)x->body.size, LABELS(route));
  counter_add(COUNTER_BYTES_OUT, (double)x->reply.size, LABELS(route));
}

/* ---- Gauges, taken when asked for ---- */

static void take_pool(const service *s) {
  int count[POOL_STATES];
  pool_states(s->pool, count);
  for (int k = 0; k < POOL_STATES; k++) {
    counter_set(COUNTER_WORKERS, count[k], LABELS(pool_state_name(k)));
  }
  counter_set(COUNTER_QUEUE, pool_waiting(s->pool), NO_LABELS);
  counter_set(COUNTER_QUEUE_LIMIT, (double)s->set->queue, NO_LABELS);
  counter_set(COUNTER_WORKER_LIMIT, (double)s->set->limits.memory_bytes, NO_LABELS);
}

/* Resident memory of a process (bytes), 0 if it is gone. */
static double resident(pid_t pid) {
  char path[64];
  long long pages = 0;
  snprintf(path, sizeof path, "/proc/%ld/statm", (long)pid);
  FILE *file = fopen(path, "re");
  if (file == NULL) return 0;
  // NOLINTNEXTLINE(cert-err34-c): the kernel writes what can be read
  if (fscanf(file, "%*s %lld", &pages) != 1) pages = 0;
  fclose(file);
  return (double)pages * (double)sysconf(_SC_PAGESIZE);
}

static void take_memory(const service *s) {
  double sum = 0;
  for (int k = 0; k < pool_count(s->pool); k++) {
    if (pool_pid(s->pool, k) > 0) sum += resident(pool_pid(s->pool, k));
  }
  counter_set(COUNTER_WORKER_MEMORY, sum, NO_LABELS);
  counter_set(COUNTER_MEMORY, resident(getpid()), NO_LABELS);
}

static void take_jobs(const service *s) {
  const job_counts counts = jobs_counts(s->jobs);
  counter_set(COUNTER_JOBS, (double)counts.waiting, LABELS(job_state_name(JOB_ACCEPTED)));
  counter_set(COUNTER_JOBS, (double)counts.running, LABELS(job_state_name(JOB_RUNNING)));
  for (int k = 0; k < JOB_STATES; k++) {
    if (!job_state_is_final((job_state)k)) continue;
    counter_set(COUNTER_JOBS_ENDED, (double)counts.ended[k], LABELS(job_state_name((job_state)k)));
  }
  counter_set(COUNTER_JOBS_ROOM, (double)jobs_room(s->jobs), NO_LABELS);
  counter_set(COUNTER_JOBS_MEMORY, (double)counts.memory, NO_LABELS);
  counter_set(COUNTER_JOBS_MEMORY_MOST, (double)jobs_most_memory(s->jobs), NO_LABELS);
}

static double size_of(const char *directory, const char *name) {
  char path[PARAM_TEXT + 32];
  struct stat facts;
  snprintf(path, sizeof path, "%s/%s", directory, name);
  return stat(path, &facts) == 0 ? (double)facts.st_size : 0;
}

static void take_store(const service *s) {
  struct statvfs facts;
  const char *at = s->set->data_dir;
  counter_set(COUNTER_STORE_BYTES, size_of(at, STORE_DATABASE) + size_of(at, STORE_DATABASE "-wal"),
              NO_LABELS);
  if (statvfs(s->set->data_dir, &facts) != 0) return;
  counter_set(COUNTER_STORE_FREE, (double)facts.f_bavail * (double)facts.f_frsize, NO_LABELS);
}

static int open_descriptors(void) {
  DIR *list = opendir("/proc/self/fd");
  int count = -3; /* itself, . and .. */
  if (list == NULL) return 0;
  while (readdir(list) != NULL) count++;
  closedir(list);
  return count;
}

static double seconds_of(struct timeval t) {
  return (double)t.tv_sec + 1e-6 * (double)t.tv_usec;
}

static void take_process(const service *s) {
  struct rusage usage;
  struct rlimit limit;
  (void)s;
  getrusage(RUSAGE_SELF, &usage);
  getrlimit(RLIMIT_NOFILE, &limit);
  counter_set(COUNTER_CPU, seconds_of(usage.ru_utime) + seconds_of(usage.ru_stime), NO_LABELS);
  counter_set(COUNTER_DESCRIPTORS, open_descriptors(), NO_LABELS);
  counter_set(COUNTER_DESCRIPTORS_MAX, (double)limit.rlim_cur, NO_LABELS);
}

static void take_ready(const service *s) {
  const char *name, *reason;
  for (int k = 0;; k++) {
    const bool holds = ready_check(s, k, &name, &reason);
    if (name == NULL) return;
    counter_set(COUNTER_READY, holds, LABELS(name));
  }
}

static void (*const takers[])(const service *) = {take_pool,  take_jobs,    take_memory,
                                                  take_store, take_process, take_ready};

/* ---- Handlers ---- */

void metrics_begin(const service *s) {
  (void)s;
  counter_set(COUNTER_BUILD, 1, LABELS(SCATTERD_VERSION));
  counter_set(COUNTER_START, (double)time(NULL), NO_LABELS);
}

void metrics_serve(const service *s, exchange *x) {
  size_t size = 0;
  for (size_t k = 0; k < sizeof takers / sizeof *takers; k++) takers[k](s);
  char *text = counter_text(&size);
  if (text != NULL) exchange_bytes(x, 200, counter_media, text, size);
  if (text == NULL) exchange_refuse(x, 503, "out of memory");
  negotiate_coding(x);
}

void metrics_ready(const service *s, exchange *x) {
  char *bytes = NULL, reasons[256] = "";
  const char *name, *reason;
  for (int k = 0; k == 0 || name != NULL; k++) {
    if (ready_check(s, k, &name, &reason)) continue;
    const size_t used = strlen(reasons);
    snprintf(reasons + used, sizeof reasons - used, "%s%s", used > 0 ? "; " : "", reason);
  }
  if (*reasons != '\0') {
    exchange_add(x, "Retry-After", "1");
    exchange_refuse(x, 503, "%s", reasons);
  } else if (asprintf(&bytes, "{\"status\":\"ready\",\"workers\":%d}", pool_ready(s->pool)) > 0) {
    exchange_bytes(x, 200, media_type(MEDIA_JSON), bytes, strlen(bytes));
  } else {
    exchange_refuse(x, 503, "out of memory");
  }
}
