#include "batch_results.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "gate.h"
#include "http.h"
#include "job_status.h"
#include "negotiate.h"

static const double late_seconds = 2;

typedef struct {
  bool by_line;
  const char *first, *between, *after, *last; /* around all entries, between and after each */
} layout;

static const layout document = {false, "{\"results\":[", ",", "", "]}"};
static const layout lines = {true, "", "", "\n", ""};

struct batch_results {
  const service *service;
  exchange *x;
  job_row batch;
  job_watch watch;
  bool over; /* no further part will end */
  const layout *layout;
  int entries;     /* begun */
  double finished; /* by line: when the last one shown had */
  bool *shown;     /* by line: which parts have been */
  bool began, ended;
  bool broken; /* what is due is not to be had */
  /* the entry being sent: text, bytes of the file, closing */
  char *text;
  size_t size, sent;
  int file;
  size_t file_size, file_sent;
  bool open; /* its closing is due */
  /* the part being rendered */
  job_row part;
  int body;
  pool_task *task;
};

/* ---- Pieces ---- */

static void say(batch_results *b, char *text) {
  b->broken = text == NULL;
  b->text = text;
  b->size = text != NULL ? strlen(text) : 0;
  b->sent = 0;
}

/* Begins the entry of a part: all before its value. */
static void begin_entry(batch_results *b, const job_row *part, const char *member,
                        const char *value, size_t size) {
  char *text = NULL;
  const char *between = b->entries++ > 0 ? b->layout->between : "";
  if (asprintf(&text, "%s{\"index\":%d,\"jobID\":\"%s\",\"status\":\"%s\"%s%s%s%.*s", between,
               part->part, part->id, job_state_name((job_state)part->state),
               *member != '\0' ? ",\"" : "", member, *member != '\0' ? "\":" : "", (int)size,
               value) < 0) {
    text = NULL;
  }
  b->open = true;
  say(b, text);
}

static void begin_with_address(batch_results *b, const job_row *part) {
  char href[EXCHANGE_BASE + 128];
  snprintf(href, sizeof href, "\"%s/jobs/%s/results\"", b->x->base, part->id);
  begin_entry(b, part, "href", href, strlen(href));
}

/* ---- Rendering ---- */

static void rendered(void *context, const pool_outcome *o) {
  batch_results *b = context;
  b->task = NULL;
  close(b->body);
  b->body = -1;
  if (o->end == POOL_REPLY && o->status == 200 && strcmp(o->type, media_type(MEDIA_JSON)) == 0) {
    begin_entry(b, &b->part, "results", "", 0);
    b->file = o->fd;
    b->file_size = o->size;
    b->file_sent = 0;
  } else {
    if (o->fd >= 0) close(o->fd);
    begin_with_address(b, &b->part);
  }
  http_wake(b->x);
}

static void render(batch_results *b) {
  static const pool_calls calls = {rendered, NULL};
  const service *s = b->service;
  ipc_ask ask = {.work = IPC_RENDER,
                 .size = b->part.result_size,
                 .content = MEDIA_CBOR,
                 .content_coding = (coding)b->part.result_coding,
                 .accept = media_wish(MEDIA_JSON),
                 .limits = s->set->limits};
  gate_ask_again(s->gate, b->part.submitter, &ask);
  snprintf(ask.process, sizeof ask.process, "%s", b->part.process);
  snprintf(ask.results_url, sizeof ask.results_url, "%s/jobs/%s/results", b->x->base, b->part.id);
  b->body = jobs_result(s->jobs, &b->part);
  if (b->body >= 0) b->task = pool_submit(s->pool, &ask, b->body, &calls, b);
  if (b->task != NULL) return;
  if (b->body >= 0) close(b->body);
  b->body = -1;
  begin_with_address(b, &b->part);
}

/* ---- What comes next ---- */

static bool show_part(batch_results *b) {
  const int k = b->part.part;
  if (k < 0 || k >= b->batch.parts || b->shown[k]) return false;
  b->shown[k] = true;
  b->finished = fmax(b->finished, b->part.finished);
  return true;
}

/* Parts that other daemons ran may be seen a bit later than others that ended after them. */
static store_result find_ended(batch_results *b, store *s) {
  store_result result;
  double after = b->finished - (store_is_shared(s) ? late_seconds : 0);
  while ((result = store_next_ended(s, b->batch.number, after, &b->part)) == STORE_OK) {
    if (show_part(b)) return STORE_OK;
    after = b->part.finished;
  }
  return result;
}

/* Of a batch that is over: what was seen too late. */
static store_result find_left(batch_results *b, store *s) {
  for (int k = 0; k < b->batch.parts; k++) {
    if (b->shown[k]) continue;
    const store_result result = store_part(s, b->batch.number, k, &b->part);
    if (result == STORE_OK && show_part(b)) return STORE_OK;
    if (result != STORE_OK && result != STORE_NONE) return result;
  }
  return STORE_NONE;
}

static store_result find_part(batch_results *b) {
  store *s = jobs_store(b->service->jobs);
  if (!b->layout->by_line) return store_part(s, b->batch.number, b->entries, &b->part);
  const store_result result = find_ended(b, s);
  return result == STORE_NONE && b->over ? find_left(b, s) : result;
}

static void begin_part(batch_results *b) {
  size_t size = 0;
  char *failure = NULL;
  if (b->part.state == JOB_SUCCESSFUL) {
    render(b);
    return;
  }
  if (b->part.state == JOB_FAILED) {
    failure = store_problem(jobs_store(b->service->jobs), b->part.number, &size);
    b->broken = failure == NULL && errno != ENOENT;
    if (b->broken) return;
  }
  begin_entry(b, &b->part, failure != NULL ? "problem" : "", failure != NULL ? failure : "", size);
  free(failure);
}

static void next_part(batch_results *b) {
  const store_result result = find_part(b);
  if (result == STORE_OK) {
    begin_part(b);
  } else if (result != STORE_NONE) {
    b->broken = true;
  } else if (b->over && !b->ended) {
    b->ended = true;
    say(b, strdup(b->layout->last));
  }
}

static void next(batch_results *b) {
  char *text = NULL;
  if (!b->began) {
    b->began = true;
    say(b, strdup(b->layout->first));
  } else if (b->open) {
    b->open = false;
    say(b, asprintf(&text, "}%s", b->layout->after) < 0 ? NULL : text);
  } else {
    next_part(b);
  }
}

static ssize_t take_text(batch_results *b, char *room, size_t size) {
  const size_t left = b->size - b->sent, step = left < size ? left : size;
  memcpy(room, b->text + b->sent, step);
  b->sent += step;
  if (b->sent < b->size) return (ssize_t)step;
  free(b->text);
  b->text = NULL;
  return (ssize_t)step;
}

/* Line ends in a JSON document are blanks; here they would end the entry. */
static ssize_t take_file(batch_results *b, char *room, size_t size) {
  const size_t left = b->file_size - b->file_sent, step = left < size ? left : size;
  const ssize_t got = pread(b->file, room, step, (off_t)b->file_sent);
  for (ssize_t k = 0; k < got; k++) room[k] = room[k] == '\n' ? ' ' : room[k];
  b->file_sent += got > 0 ? (size_t)got : left;
  b->broken = got <= 0 && left > 0;
  if (b->file_sent == b->file_size) {
    close(b->file);
    b->file = -1;
  }
  return got > 0 ? got : 0;
}

static ssize_t read_pieces(void *self, char *room, size_t size) {
  batch_results *b = self;
  for (;;) {
    const ssize_t got = b->text != NULL   ? take_text(b, room, size)
                        : b->file >= 0    ? take_file(b, room, size)
                        : b->task != NULL ? 0
                                          : -1;
    if (got > 0 || b->task != NULL) return got > 0 ? got : 0;
    if (b->ended && b->text == NULL && !b->broken) return EXCHANGE_END;
    if (b->text == NULL && b->file < 0 && !b->broken) next(b);
    if (b->broken) return EXCHANGE_BROKEN;
    const bool idle = b->text == NULL && b->file < 0;
    if (idle && b->task == NULL && !b->ended) return 0;
  }
}

static void changed(void *self, const job_view *now) {
  batch_results *b = self;
  b->over = now->active == NULL;
  http_wake(b->x);
}

/* ---- The reply ---- */

batch_results *batch_results_new(const service *s, exchange *x, const job_view *batch) {
  const char *const offers[] = {media_type(MEDIA_JSON), media_type(MEDIA_NDJSON)};
  const int chosen = negotiate(x, offers, 2);
  if (chosen < 0) return NULL;
  if (chosen == 0 && batch->active != NULL) {
    exchange_add(x, "Retry-After", "1");
    job_refuse_unready(x, &batch->row);
    return NULL;
  }
  batch_results *b = calloc(1, sizeof *b);
  if (b == NULL) {
    exchange_refuse(x, 503, "out of memory");
    return NULL;
  }
  *b = (batch_results){.service = s, .x = x, .batch = batch->row, .file = -1, .body = -1};
  b->shown = calloc((size_t)batch->row.parts, sizeof *b->shown);
  if (b->shown == NULL) {
    free(b);
    exchange_refuse(x, 503, "out of memory");
    return NULL;
  }
  b->layout = chosen == 0 ? &document : &lines;
  b->over = batch->active == NULL;
  b->watch = (job_watch){.changed = changed, .self = b};
  if (!b->over) job_watch_on(batch->active, &b->watch);
  exchange_stream(x, 200, offers[chosen], (exchange_source){b, read_pieces});
  return b;
}

void batch_results_free(batch_results **b) {
  if (*b == NULL) return;
  if ((*b)->task != NULL) pool_cancel((*b)->service->pool, (*b)->task);
  job_watch_off(&(*b)->watch);
  if ((*b)->file >= 0) close((*b)->file);
  if ((*b)->body >= 0) close((*b)->body);
  free((*b)->text);
  free((*b)->shown);
  free(*b);
  *b = NULL;
}
