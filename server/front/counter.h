/* counter.h - what the front counts, in one table: counters, gauges and histograms with their
 * labels, and their text for Prometheus.
 *
 * The front is one thread and its counters are the process's: counting is one line wherever
 * something happens, and needs no object handed through. Values of labels come from closed sets
 * (routes, methods, statuses, states), never from a client; should that ever fail, a metric has at
 * most COUNTER_SERIES_MAX of them, later ones are counted as "other". Test: unit.counter.
 */
#ifndef SCATTERD_COUNTER_H
#define SCATTERD_COUNTER_H

#include <stddef.h>
#include <stdio.h>

enum { COUNTER_LABELS = 3, COUNTER_SERIES_MAX = 512 };

/* symbol, kind, name, labels (separated by spaces), help */
#define COUNTER_LIST(X)                                                                          \
  X(COUNTER_BUILD, GAUGE, "scatterd_build_info", "version", "1, by the version that runs")       \
  X(COUNTER_REQUESTS, COUNT, "scatterd_http_requests_total", "route method status",              \
    "Requests that ended, by the status of their reply (aborted: the client left before it)")    \
  X(COUNTER_REQUEST_SECONDS, HISTOGRAM, "scatterd_http_request_seconds", "route",                \
    "Time from the header of a request to the end of its reply")                                 \
  X(COUNTER_BYTES_IN, COUNT, "scatterd_http_request_bytes_total", "route", "Bytes of bodies")    \
  X(COUNTER_BYTES_OUT, COUNT, "scatterd_http_response_bytes_total", "route",                     \
    "Bytes of replies, without their headers")                                                   \
  X(COUNTER_RUN_SECONDS, HISTOGRAM, "scatterd_run_seconds", "process work",                      \
    "Time of a request on a worker, by what is done with it: run, job, check or render")         \
  X(COUNTER_RUNS, COUNT, "scatterd_runs_total", "process work end",                              \
    "Requests that left a worker, by how: reply, memory, time, crash or stopped")                \
  X(COUNTER_CANCELLED, COUNT, "scatterd_runs_cancelled_total", "process",                        \
    "Requests taken off a worker because nobody waits for them any more")                        \
  X(COUNTER_WAIT_SECONDS, HISTOGRAM, "scatterd_queue_wait_seconds", "",                          \
    "Time that a request waited for a worker")                                                   \
  X(COUNTER_PHASE_SECONDS, COUNT, "scatterd_phase_seconds_total", "phase",                       \
    "Time of workers in each phase of their requests")                                           \
  X(COUNTER_QUEUE, GAUGE, "scatterd_queue_length", "", "Requests that wait for a worker")        \
  X(COUNTER_QUEUE_LIMIT, GAUGE, "scatterd_queue_limit", "", "Requests that may wait")            \
  X(COUNTER_WORKERS, GAUGE, "scatterd_workers", "state", "Workers in each state")                \
  X(COUNTER_STARTS, COUNT, "scatterd_worker_starts_total", "", "Workers started")                \
  X(COUNTER_EXITS, COUNT, "scatterd_worker_exits_total", "how",                                  \
    "Workers that ended: planned (recycled, dismissed, killed by us), code or signal")           \
  X(COUNTER_WORKER_MEMORY, GAUGE, "scatterd_workers_resident_memory_bytes", "",                  \
    "Resident memory of all workers")                                                            \
  X(COUNTER_WORKER_LIMIT, GAUGE, "scatterd_worker_memory_limit_bytes", "",                       \
    "Address space that one worker may have")                                                    \
  X(COUNTER_STORE_FREE, GAUGE, "scatterd_store_free_bytes", "",                                  \
    "Room for this user on the file system of the data directory")                               \
  X(COUNTER_JOBS, GAUGE, "scatterd_jobs", "state", "Jobs that are not over: accepted, running")  \
  X(COUNTER_JOBS_ENDED, COUNT, "scatterd_jobs_ended_total", "state", "Jobs that ended, by how")  \
  X(COUNTER_JOBS_ROOM, GAUGE, "scatterd_jobs_room", "", "Jobs that may still be accepted")       \
  X(COUNTER_JOBS_MEMORY, GAUGE, "scatterd_jobs_memory_bytes", "",                                \
    "Estimated peak memory of the running jobs")                                                 \
  X(COUNTER_JOBS_MEMORY_MOST, GAUGE, "scatterd_jobs_memory_limit_bytes", "",                     \
    "Most that one job may be estimated to need")                                                \
  X(COUNTER_STORE_BYTES, GAUGE, "scatterd_store_bytes", "",                                      \
    "Size of the store's database with its log")                                                 \
  X(COUNTER_READY, GAUGE, "scatterd_ready", "check", "1 where a check of /readyz holds, else 0") \
  X(COUNTER_CPU, COUNT, "process_cpu_seconds_total", "", "Processor time of the front")          \
  X(COUNTER_MEMORY, GAUGE, "process_resident_memory_bytes", "", "Resident memory of the front")  \
  X(COUNTER_DESCRIPTORS, GAUGE, "process_open_fds", "", "Descriptors the front has open")        \
  X(COUNTER_DESCRIPTORS_MAX, GAUGE, "process_max_fds", "", "Descriptors the front may open")     \
  X(COUNTER_START, GAUGE, "process_start_time_seconds", "", "When the front started (Unix time)")

#define COUNTER_ENUM(symbol, kind, name, labels, help) symbol,
typedef enum { COUNTER_LIST(COUNTER_ENUM) COUNTER_COUNT } counter;
#undef COUNTER_ENUM

/* Values of the labels of a row, in its order. */
typedef struct {
  const char *value[COUNTER_LABELS];
} counter_labels;
#define LABELS(...) ((counter_labels){{__VA_ARGS__}})
#define NO_LABELS ((counter_labels){{NULL}})

void counter_add(counter c, double by, counter_labels labels);          /* by >= 0 */
void counter_set(counter c, double value, counter_labels labels);       /* gauge, or a count kept
                                                                           elsewhere */
void counter_observe(counter c, double seconds, counter_labels labels); /* histogram */

/* All of it in the text format 0.0.4, malloc'ed; NULL when out of memory. */
char *counter_text(size_t *size);
extern const char counter_media[];

/* What each metric means, as a page (Markdown). */
void counter_reference(FILE *out);

/* Forgets everything. */
void counter_reset(void);

#endif
