#include "rendering.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "gate.h"
#include "http.h"
#include "job_status.h"
#include "media.h"
#include "outcome.h"

struct rendering {
  const service *service;
  exchange *x;
  int body;
  pool_task *task;
};

static void done(void *context, const pool_outcome *o) {
  rendering *r = context;
  r->task = NULL;
  exchange_add(r->x, "Vary", "Accept, Accept-Encoding");
  outcome_reply(r->x, &r->service->set->limits, o);
  http_deliver(r->x);
}

static bool wish(exchange *x, ipc_ask *ask) {
  char room[512];
  const char *text = http_field(x, "Accept-Encoding", room, sizeof room);
  char part[8];
  const bool is_part = http_field(x, "Range", part, sizeof part) != NULL;
  if (!coding_choose(is_part ? NULL : text, &ask->accept_coding)) {
    exchange_refuse(x, 406, "Accept-Encoding: got \"%.100s\", needs gzip, zstd or identity", text);
    return false;
  }
  ask->accept = media_wishes(http_field(x, "Accept", room, sizeof room));
  return true;
}

/* When a job is dismissed its file goes first. */
static void refuse_unopened(exchange *x, const char *id, int error) {
  if (error == ENOENT) {
    job_refuse_dismissed(x, id);
  } else {
    job_refuse_store(x, store_blame("result", error));
  }
}

rendering *rendering_new(const service *s, exchange *x, const job_row *row, const char *output) {
  static const pool_calls calls = {done, NULL};
  ipc_ask ask = {.work = IPC_RENDER,
                 .size = row->result_size,
                 .content = MEDIA_CBOR,
                 .content_coding = (coding)row->result_coding,
                 .limits = s->set->limits};
  gate_ask_again(s->gate, row->submitter, &ask);
  snprintf(ask.process, sizeof ask.process, "%s", row->process);
  snprintf(ask.output, sizeof ask.output, "%s", output);
  snprintf(ask.results_url, sizeof ask.results_url, "%s/jobs/%s/results", x->base, row->id);
  if (!wish(x, &ask)) return NULL;
  rendering *r = calloc(1, sizeof *r);
  if (r == NULL) {
    exchange_refuse(x, 503, "out of memory");
    return NULL;
  }
  *r = (rendering){.service = s, .x = x, .body = jobs_result(s->jobs, row)};
  if (r->body < 0) {
    refuse_unopened(x, row->id, errno);
  } else {
    r->task = pool_submit(s->pool, &ask, r->body, &calls, r);
    if (r->task != NULL) return r;
    outcome_refuse_full(x, s->pool, s->set->queue);
  }
  rendering_free(&r);
  return NULL;
}

void rendering_free(rendering **r) {
  if (*r == NULL) return;
  if ((*r)->task != NULL) pool_cancel((*r)->service->pool, (*r)->task);
  if ((*r)->body >= 0) close((*r)->body);
  free(*r);
  *r = NULL;
}
