#include "front.h"

#include <errno.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/resource.h>
#include <sys/signalfd.h>
#include <sys/stat.h>
#include <unistd.h>

#include "callback.h"
#include "clock.h"
#include "data.h"
#include "events.h"
#include "fetch.h"
#include "gate.h"
#include "listener.h"
#include "log.h"
#include "metrics.h"
#include "outbound.h"
#include "privilege.h"
#include "route.h"
#include "systemd.h"
#include "tls.h"

static const double farewell_seconds = 1; /* for the last replies to leave */

typedef struct {
  parameters *set;
  loop *loop;
  listener listener;
  service service;
  http *http;
  int signals;
  loop_source signalled;
  double stop; /* when patience with running requests ends; INFINITY while serving */
} front;

/* ---- Starting ---- */

static bool make_directory(const char *path, fault *why) {
  char part[PARAM_TEXT];
  for (size_t k = 1; k <= strlen(path); k++) {
    if (path[k] != '/' && path[k] != '\0') continue;
    snprintf(part, sizeof part, "%.*s", (int)k, path);
    if (mkdir(part, 0700) != 0 && errno != EEXIST) {
      return fault_set(why, "data-dir: cannot make %.200s: %s", part, strerror(errno));
    }
  }
  if (access(path, W_OK | X_OK) == 0) return true;
  return fault_set(why, "data-dir: cannot write in %.200s: %s", path, strerror(errno));
}

static bool find_data_dir(parameters *set, fault *why) {
  const char *data = getenv("XDG_DATA_HOME"), *home = getenv("HOME");
  if (*set->data_dir == '\0') {
    int length = -1;
    if (data != NULL && *data == '/') {
      length = snprintf(set->data_dir, PARAM_TEXT, "%s/scatterd", data);
    } else if (home != NULL && *home == '/') {
      length = snprintf(set->data_dir, PARAM_TEXT, "%s/.local/share/scatterd", home);
    }
    if (length < 0 || length >= PARAM_TEXT) {
      return fault_set(why, "data-dir: got none, and neither XDG_DATA_HOME nor HOME helps");
    }
  }
  return make_directory(set->data_dir, why);
}

/* A connection needs up to four descriptors: its socket, a body, a reply, and one lingering. */
static bool raise_descriptors(const parameters *set, fault *why) {
  const rlim_t needed = (rlim_t)(4 * set->connections + 4 * set->workers + 64);
  struct rlimit limit;
  getrlimit(RLIMIT_NOFILE, &limit);
  if (limit.rlim_cur >= needed) return true;
  limit.rlim_cur = limit.rlim_max < needed ? limit.rlim_max : needed;
  setrlimit(RLIMIT_NOFILE, &limit);
  if (limit.rlim_cur >= needed) return true;
  return fault_set(
      why, "connections: got %lld, which needs %llu descriptors; the system allows %llu",
      (long long)set->connections, (unsigned long long)needed, (unsigned long long)limit.rlim_max);
}

static void stop_now(front *f) {
  loop_stop(f->loop);
}

static bool read_certificate(const parameters *set, fault *why) {
  if (*set->tls_certificate == '\0') {
    return *set->tls_key == '\0' || fault_set(why, "tls-key: got no tls-certificate");
  }
  return tls_read(set->tls_certificate, *set->tls_key != '\0' ? set->tls_key : set->tls_certificate,
                  why);
}

/* What cannot be read stays as it was. */
static void reload(front *f) {
  fault why;
  systemd_reloading();
  if (!gate_reload(f->service.gate, &why)) log_say(LOG_ERROR, "reload", "%s", why.text);
  if (!read_certificate(f->set, &why)) log_say(LOG_ERROR, "reload", "%s", why.text);
  systemd_ready();
}

static void on_signal(void *self, uint32_t events) {
  front *f = self;
  struct signalfd_siginfo signal;
  (void)events;
  if (read(f->signals, &signal, sizeof signal) != sizeof signal) return;
  if (signal.ssi_signo == SIGHUP) {
    reload(f);
    return;
  }
  if (f->stop < INFINITY) {
    stop_now(f);
    return;
  }
  log_say(LOG_INFO, "stopping", "signal %u of process %u: no new requests, %d to end",
          signal.ssi_signo, signal.ssi_pid, http_pending(f->http));
  f->stop = loop_now() + f->set->grace_seconds;
  systemd_stopping(f->set->grace_seconds + farewell_seconds);
  http_quiesce(f->http);
  waits_stop(f->service.waits);
  streams_stop(f->service.streams);
}

/* A reload that is asked for during the start waits for its end; without this it would be the end.
 */
static void hold_reload(void) {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGHUP);
  sigprocmask(SIG_BLOCK, &set, NULL);
}

static bool watch_signals(front *f, fault *why) {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGTERM);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGHUP);
  sigprocmask(SIG_BLOCK, &set, NULL);
  signal(SIGPIPE, SIG_IGN);
  f->signals = signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK);
  f->signalled = (loop_source){on_signal, f};
  if (f->signals >= 0 && loop_watch(f->loop, f->signals, EPOLLIN, &f->signalled)) return true;
  return fault_set(why, "cannot watch signals: %s", strerror(errno));
}

/* Once stopping, looks whether the last request has ended. */
static double stop_due(void *self) {
  const front *f = self;
  if (f->stop == INFINITY) return INFINITY;
  return http_pending(f->http) == 0 ? 0 : f->stop;
}

static void stop_run(void *self) {
  stop_now(self);
}

/* Objects under /data, and what workers ask for. */
static bool start_values(front *f) {
  service *s = &f->service;
  s->data = data_new(f->loop, f->set, s->store, s->clerk);
  s->fetches = s->data != NULL ? fetches_new(s) : NULL;
  return s->fetches != NULL;
}

static void narrow(void *self, const char *submitter, ipc_ask *ask) {
  gate_ask_again(self, submitter, ask);
}

static bool keep(void *self, const char *submitter, int64_t size,
                 const allowance_counter *counter) {
  return gate_keep(self, submitter, size, counter);
}

/* While root, which may be the only one to read the files. */
static bool start_access(front *f, fault *why) {
  const parameters *set = f->set;
  f->service.gate = gate_new(set, why);
  if (f->service.gate == NULL || !read_certificate(set, why)) return false;
  if (gate_is_on(f->service.gate) || f->listener.is_local || set->allow_anonymous) return true;
  return fault_set(
      why,
      "listen: other machines reach %.100s, and there are no tokens: make a file of them "
      "(tokens; scatterd token NAME >> FILE), listen on 127.0.0.1, or let everybody in "
      "(allow-anonymous 1)",
      f->listener.address);
}

/* By which names the service may be called. */
static host_rule rule_of(const front *f) {
  if (f->listener.is_unix) return HOST_ANY;
  if (gate_is_on(f->service.gate) && *f->set->hosts == '\0') return HOST_ANY;
  return f->listener.is_local ? HOST_LOOPBACK : HOST_ADDRESS;
}

static bool start(front *f, fault *why) {
  if (!find_data_dir(f->set, why) || !raise_descriptors(f->set, why)) return false;
  if (!listener_open(&f->listener, f->set->listen, why)) return false;
  if (!start_access(f, why)) return false;
  if (!privilege_drop(f->set->user, f->set->data_dir, why)) return false;
  f->loop = loop_new();
  if (f->loop == NULL) return fault_set(why, "cannot start: %s", strerror(errno));
  if (!watch_signals(f, why)) return false;
  f->service.set = f->set;
  f->service.clerk = clerk_new(f->loop, f->set->aside_bytes, why);
  if (f->service.clerk == NULL) return false;
  f->service.executor = executor_new(f->loop, f->set, why);
  if (f->service.executor == NULL) return false;
  f->service.pool = pool_new(f->loop, f->set, why);
  if (f->service.pool == NULL) return false;
  f->service.store = store_open(f->set->data_dir, f->set->store, why);
  if (f->service.store == NULL) return false;
  f->service.clock = clock_watch_new(f->loop, &f->service);
  if (f->service.clock == NULL) return fault_set(why, "out of memory");
  f->service.jobs = jobs_new(f->loop, f->set, f->service.pool, f->service.executor,
                             f->service.store, f->service.clerk, why);
  if (f->service.jobs == NULL) return false;
  jobs_on_owners(f->service.jobs, &(job_owners){f->service.gate, narrow, keep});
  f->service.waits = waits_new(f->loop);
  f->service.streams = streams_new(f->loop, f->set);
  f->service.outbound = outbound_new(f->loop);
  f->service.callbacks = callbacks_new(f->loop, &f->service);
  if (f->service.waits == NULL || f->service.streams == NULL || f->service.outbound == NULL ||
      f->service.callbacks == NULL) {
    return fault_set(why, "out of memory");
  }
  if (!start_values(f)) return fault_set(why, "out of memory");
  metrics_begin(&f->service);
  const http_handler handler = route_handler(&f->service);
  const http_place place = {f->listener.fd, f->listener.host, rule_of(f)};
  f->http = http_new(f->loop, f->set, &place, &handler, why);
  if (f->http == NULL) return false;
  loop_add(f->loop, (loop_chore){stop_due, stop_run, f});
  return true;
}

/* ---- Stopping ---- */

/* Ends the requests that are still running, those whose bytes are being kept as they should, and
 * gives their replies a moment to leave. */
static void say_farewell(front *f) {
  pool_stop(f->service.pool);
  clerk_finish(f->service.clerk);
  f->stop = loop_now() + farewell_seconds;
  if (http_pending(f->http) > 0) loop_run(f->loop);
}

static void end(front *f) {
  http_free(&f->http);
  if (f->service.pool != NULL) pool_stop(f->service.pool);
  if (f->service.executor != NULL) executor_stop(f->service.executor);
  callbacks_free(&f->service.callbacks);
  fetches_free(&f->service.fetches);
  data_free(&f->service.data);
  outbound_free(&f->service.outbound);
  jobs_free(&f->service.jobs);
  waits_free(&f->service.waits);
  streams_free(&f->service.streams);
  store_close(&f->service.store);
  clock_watch_free(&f->service.clock);
  pool_free(&f->service.pool);
  executor_free(&f->service.executor);
  gate_free(&f->service.gate);
  tls_forget();
  clerk_free(&f->service.clerk);
  if (f->signals >= 0) close(f->signals);
  loop_free(&f->loop);
  listener_close(&f->listener);
}

static void log_start(const front *f) {
  log_line line;
  log_begin(&line, LOG_INFO, "listening");
  log_text(&line, "address", f->listener.address);
  log_count(&line, "pid", getpid());
  log_count(&line, "workers", pool_workers(f->set->workers));
  log_text(&line, "data-dir", f->set->data_dir);
  log_end(&line);
}

int front_main(parameters *set) {
  front f = {.set = set, .listener = {.fd = -1}, .signals = -1, .stop = INFINITY};
  fault why;
  hold_reload();
  log_limit((log_level)set->log_level);
  const bool started = start(&f, &why);
  if (started) {
    log_start(&f);
    systemd_ready();
    loop_run(f.loop);
    say_farewell(&f);
    log_say(LOG_INFO, "stopped", "done");
  } else {
    fprintf(stderr, "scatterd: %s\n", why.text);
  }
  end(&f);
  return started ? 0 : 1;
}
