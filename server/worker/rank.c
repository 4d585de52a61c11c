#include "rank.h"

#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include "answer.h"
#include "run_dir.h"
#include "sanitizer.h"
#include "teller.h"

/* News within a phase at most this often: each is a write to a file. */
static const double report_seconds = 0.25;

typedef struct {
  int dir;
  teller teller;
  bool wants_values; /* something is to be fetched, which only a worker's front can */
} run;

/* ---- what an answer asks for ---- */

static bool report(void *context, const char *phase, double fraction) {
  run *r = context;
  ipc_news news;
  /* what is not heard costs nothing but a bar that stands */
  if (teller_takes(&r->teller, phase, fraction, &news)) (void)run_dir_tell(r->dir, &news);
  return true;
}

static void hear_residual(void *context, double value) {
  ((run *)context)->teller.residual = value;
}

static void fetch(void *context, const char *href, ask_fetched *out) {
  (void)href;
  ((run *)context)->wants_values = true;
  *out = (ask_fetched){.status = 503, .detail = "can be fetched by a worker only"};
}

static void release(void *context, ask_fetched *out) {
  (void)context, (void)out;
}

static bool checkpoint(void *context, const void *bytes, size_t size) {
  const run *r = context;
  const ipc_news news = {.kind = IPC_CHECKPOINT, .size = (int64_t)size};
  if (run_dir_put(r->dir, "checkpoint", bytes, size)) (void)run_dir_tell(r->dir, &news);
  return true; /* the run goes on without it */
}

/* ---- the reply ---- */

static bool send_reply(const run *r, const reply *answered) {
  ipc_news news = {.kind = r->wants_values ? IPC_FETCH : IPC_REPLY,
                   .time = teller_now(),
                   .coding = answered->coding,
                   .points = answered->points,
                   .memory_bytes = answered->memory_bytes};
  if (answered->bytes != NULL && run_dir_put(r->dir, "result", answered->bytes, answered->size)) {
    news.status = answered->status;
    news.size = (int64_t)answered->size;
    snprintf(news.type, sizeof news.type, "%s", answered->type);
    memcpy(news.detail, answered->detail, sizeof news.detail);
  } else if (answered->bytes != NULL) {
    fprintf(stderr, "scatterd: the result cannot be written: %s\n", strerror(errno));
    return false;
  }
  return run_dir_put_reply(r->dir, &news);
}

/* ---- the run ---- */

typedef struct {
  void *bytes;
  size_t size;
} mapped;

static bool map(int dir, const char *name, mapped *m) {
  int64_t size = 0;
  const int fd = run_dir_get(dir, name, &size);
  *m = (mapped){"", 0};
  if (fd < 0) return false;
  if (size > 0) m->bytes = mmap(NULL, (size_t)size, PROT_READ, MAP_PRIVATE, fd, 0);
  close(fd);
  if (m->bytes == MAP_FAILED) return false;
  m->size = (size_t)size;
  return true;
}

static void limit(const limits *bounds) {
  const struct rlimit memory = {(rlim_t)bounds->memory_bytes, (rlim_t)bounds->memory_bytes};
  const struct rlimit none = {0, 0};
  if (!SANITIZED) setrlimit(RLIMIT_AS, &memory);
  setrlimit(RLIMIT_CORE, &none);
  prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
}

static void answer_into(run *r, const ipc_ask *question, struct by_ranks *ranks, mapped body,
                        mapped state, reply *answered) {
  const bool speaks = answer_ranks_place(ranks) == 0;
  ask a = {.work = question->work,
           .process = question->process,
           .body = body.bytes,
           .size = body.size,
           .content = question->content,
           .content_coding = question->content_coding,
           .accept = question->accept,
           .accept_coding = question->accept_coding,
           .limits = &question->limits,
           .checkpoint = state.size > 0 ? state.bytes : NULL,
           .checkpoint_size = state.size,
           .ranks = ranks,
           .calls = {.context = r, .fetch = fetch, .release = release}};
  if (speaks) {
    a.calls.report = report;
    a.calls.residual = hear_residual;
    a.calls.checkpoint = checkpoint;
    (void)run_dir_tell(r->dir, &(ipc_news){.kind = IPC_READY, .time = teller_now()});
  }
  answer(&a, answered);
}

/* What this process has to do with the reply. One that cannot go on with the others tells why and
 * ends, by which the launcher ends the others. */
static int finish(const run *r, struct by_ranks *ranks, const reply *answered) {
  const answer_role role = answer_ranks_role(ranks);
  if (role == ANSWER_LEAVES) return 0;
  if (!send_reply(r, answered)) return 3;
  if (role == ANSWER_STUCK) _exit(3);
  return 0;
}

int rank_main(const char *directory) {
  run r = {.dir = run_dir_open(directory),
           .teller = {.pause = report_seconds, .last = teller_now()}};
  ipc_ask question;
  mapped body, state = {"", 0};
  reply answered = {0};
  prctl(PR_SET_PDEATHSIG, SIGKILL); /* the launcher's death */
  if (r.dir < 0 || !run_dir_get_ask(r.dir, &question) || !map(r.dir, "body", &body)) {
    fprintf(stderr, "scatterd: %s: %s\n", directory, strerror(errno));
    return 2;
  }
  limit(&question.limits);
  if (question.checkpoint > 0) (void)map(r.dir, "state", &state); /* without it: afresh */
  struct by_ranks *ranks = answer_ranks_new();
  if (ranks == NULL) return 3;
  answer_into(&r, &question, ranks, body, state, &answered);
  const int status = finish(&r, ranks, &answered);
  answer_ranks_free(&ranks);
  free(answered.bytes);
  close(r.dir);
  return status;
}
