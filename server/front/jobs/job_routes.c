#include "job_routes.h"

#include <stdlib.h>
#include <string.h>

#include "batch_results.h"
#include "http.h"
#include "job_status.h"
#include "negotiate.h"
#include "prefer.h"
#include "rendering.h"

bool job_of_route(const service *s, exchange *x, job_view *view) {
  const store_result result = jobs_find(s->jobs, x->owner, x->item, view);
  if (result == STORE_NONE) job_refuse_missing(x, x->item);
  if (result != STORE_OK && result != STORE_NONE) job_refuse_store(x, result);
  return result == STORE_OK;
}

/* ---- GET /jobs/{id} ---- */

typedef struct {
  const service *service;
  exchange *x;
  const char *known; /* If-None-Match, NULL without */
  char room[512];
  wait wait;
} status_task;

static bool knows(const status_task *t, const char *tag) {
  return t->known != NULL && (strcmp(t->known, "*") == 0 || strstr(t->known, tag) != NULL);
}

/* 200 with the document, 304 if the client has it. */
static void reply_status(status_task *t, const job_view *view) {
  char tag[24];
  size_t size = 0;
  char *bytes = job_status_bytes(view, t->x->base, false, jobs_store(t->service->jobs), &size);
  if (bytes == NULL) {
    exchange_refuse(t->x, 503, "out of memory");
    return;
  }
  job_status_tag(bytes, size, tag);
  exchange_add(t->x, "ETag", "%s", tag);
  exchange_add(t->x, "Cache-Control", "no-cache");
  if (knows(t, tag)) {
    free(bytes);
    exchange_unchanged(t->x, size);
  } else {
    exchange_bytes(t->x, 200, media_type(MEDIA_JSON), bytes, size);
  }
}

/* With a tag of the client's: that it changed; else that it is over. */
static bool is_news(void *self, const job_view *now) {
  const status_task *t = self;
  char tag[24];
  size_t size = 0;
  if (job_state_is_final((job_state)now->row.state)) return true;
  if (t->known == NULL) return false;
  char *bytes = job_status_bytes(now, t->x->base, false, jobs_store(t->service->jobs), &size);
  if (bytes == NULL) return true;
  job_status_tag(bytes, size, tag);
  free(bytes);
  return !knows(t, tag);
}

static void waited(void *self, const job_view *now) {
  status_task *t = self;
  reply_status(t, now);
  http_deliver(t->x);
}

static status_task *status_task_new(const service *s, exchange *x) {
  status_task *t = calloc(1, sizeof *t);
  if (t == NULL) {
    exchange_refuse(x, 503, "out of memory");
    return NULL;
  }
  t->service = s;
  t->x = x;
  t->known = http_field(x, "If-None-Match", t->room, sizeof t->room);
  t->wait.enough = is_news;
  t->wait.over = waited;
  t->wait.self = t;
  return t;
}

void job_status_serve(const service *s, exchange *x) {
  char room[512];
  job_view view;
  if (!job_of_route(s, x, &view) || !negotiate_json(x)) return;
  status_task *t = x->task = status_task_new(s, x);
  if (t == NULL) return;
  const prefer p = prefer_of(http_field(x, "Prefer", room, sizeof room), s->set->wait_seconds);
  if (p.wait > 0) exchange_add(x, "Preference-Applied", "wait=%.0f", p.wait);
  if (p.wait <= 0 || view.active == NULL || is_news(t, &view)) {
    reply_status(t, &view);
    return;
  }
  t->wait.now = view;
  wait_on(s->waits, &t->wait, p.wait);
}

void job_status_end(const service *s, exchange *x) {
  status_task *t = x->task;
  (void)s;
  if (t != NULL) wait_off(&t->wait);
  free(t);
  x->task = NULL;
}

/* ---- GET /jobs/{id}/results ---- */

static void refuse_active(const service *s, exchange *x, const job_row *row) {
  (void)s;
  exchange_add(x, "Retry-After", "1");
  job_refuse_unready(x, row);
}

typedef struct {
  rendering *rendering;
  batch_results *batch;
} results_task;

static results_task *results_task_new(exchange *x) {
  x->task = calloc(1, sizeof(results_task));
  if (x->task == NULL) exchange_refuse(x, 503, "out of memory");
  return x->task;
}

static void send_results(const service *s, exchange *x, const job_row *row) {
  results_task *t = results_task_new(x);
  if (t != NULL) t->rendering = rendering_new(s, x, row, x->item2);
}

static void send_failure(const service *s, exchange *x, const job_row *row) {
  job_refuse_failed(x, s->jobs, row);
}

static void refuse_dismissed(const service *s, exchange *x, const job_row *row) {
  (void)s;
  job_refuse_dismissed(x, row->id);
}

static void (*const results[JOB_STATES])(const service *s, exchange *x, const job_row *row) = {
    [JOB_ACCEPTED] = refuse_active,     [JOB_RUNNING] = refuse_active,
    [JOB_SUCCESSFUL] = send_results,    [JOB_FAILED] = send_failure,
    [JOB_DISMISSED] = refuse_dismissed,
};

static store_result find_part(const service *s, const job_row *batch, const char *text,
                              job_row *part) {
  char *end = NULL;
  const long index = strtol(text, &end, 10);
  if (*end != '\0' || index < 0 || index >= batch->parts) return STORE_NONE;
  return store_part(jobs_store(s->jobs), batch->number, (int)index, part);
}

static void serve_part(const service *s, exchange *x, const job_row *batch) {
  job_row part;
  const store_result result = find_part(s, batch, x->item2, &part);
  if (result == STORE_NONE) {
    exchange_refuse(x, 404, "batch %s has no request \"%.64s\", it has 0 to %d", batch->id,
                    x->item2, batch->parts - 1);
  } else if (result != STORE_OK) {
    job_refuse_store(x, result);
  } else {
    *x->item2 = '\0';
    results[part.state](s, x, &part);
  }
}

/* All results of a batch, or those of its request number item2. */
static void serve_batch(const service *s, exchange *x, const job_view *view) {
  if (*x->item2 != '\0') {
    serve_part(s, x, &view->row);
    return;
  }
  results_task *t = results_task_new(x);
  if (t != NULL) t->batch = batch_results_new(s, x, view);
}

void job_results_serve(const service *s, exchange *x) {
  job_view view;
  if (!job_of_route(s, x, &view)) return;
  if (view.row.parts > 0 && view.row.state <= JOB_SUCCESSFUL) {
    serve_batch(s, x, &view);
  } else {
    results[view.row.state](s, x, &view.row);
  }
}

void job_results_end(const service *s, exchange *x) {
  results_task *t = x->task;
  (void)s;
  if (t == NULL) return;
  rendering_free(&t->rendering);
  batch_results_free(&t->batch);
  free(t);
  x->task = NULL;
}

/* ---- DELETE /jobs/{id} ---- */

void job_dismiss_serve(const service *s, exchange *x) {
  job_view view, left;
  if (!job_of_route(s, x, &view)) return;
  if (view.row.state == JOB_DISMISSED) {
    job_refuse_dismissed(x, view.row.id);
    return;
  }
  const store_result result = jobs_dismiss(s->jobs, &view.row, &left);
  if (result == STORE_OK) {
    job_status_reply(x, 200, &left, false, jobs_store(s->jobs));
  } else {
    job_refuse_store(x, result);
  }
}
