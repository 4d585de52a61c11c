#include "job_list.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "http.h"
#include "instant.h"
#include "job_status.h"
#include "negotiate.h"

enum { LIMIT = 10, LIMIT_MOST = 10000 };

/* ---- Filters ---- */

typedef struct {
  const service *service;
  const exchange *x;
  store_filter filter;
} query;

/* A reader of one argument: false when it is malformed, then *needs says what it should be. */
typedef bool reader(query *q, const char *text, const char **needs);

static bool read_count(const char *text, int64_t least, int64_t most, int64_t *out) {
  char *end = NULL;
  errno = 0;
  const long long value = isdigit((unsigned char)*text) ? strtoll(text, &end, 10) : -1;
  if (end == NULL || *end != '\0' || errno != 0 || value < least || value > most) return false;
  *out = value;
  return true;
}

static bool read_limit(query *q, const char *text, const char **needs) {
  *needs = "an integer from 1 to 10000";
  return read_count(text, 1, LIMIT_MOST, &q->filter.limit);
}

static bool read_offset(query *q, const char *text, const char **needs) {
  *needs = "an integer from 0 on";
  return read_count(text, 0, INT64_MAX / 2, &q->filter.offset);
}

/* The next item of "a,b"; its length is -1 at the end. */
static int next_item(const char **rest, const char **item) {
  if (*rest == NULL) return -1;
  *item = *rest;
  const size_t length = strcspn(*rest, ",");
  *rest = (*rest)[length] == ',' ? *rest + length + 1 : NULL;
  return (int)length;
}

static bool read_type(query *q, const char *text, const char **needs) {
  const char *item;
  (void)q;
  *needs = "process";
  for (int length; (length = next_item(&text, &item)) >= 0;) {
    if (length != 7 || strncmp(item, "process", 7) != 0) return false;
  }
  return true;
}

static bool read_status(query *q, const char *text, const char **needs) {
  const char *item;
  *needs = "some of accepted, running, successful, failed, dismissed";
  q->filter.states = 0;
  for (int length; (length = next_item(&text, &item)) >= 0;) {
    const int state = job_state_of(item, length);
    if (state < 0) return false;
    q->filter.states |= 1u << state;
  }
  return true;
}

static bool read_process(query *q, const char *text, const char **needs) {
  const int length = snprintf(q->filter.processes, sizeof q->filter.processes, ",%s,", text);
  *needs = "ids of processes";
  return *text != '\0' && length > 0 && (size_t)length < sizeof q->filter.processes;
}

static bool read_datetime(query *q, const char *text, const char **needs) {
  *needs = "a time as in RFC 3339, or two of them with / between, or .. for one of the two";
  return instant_interval(text, &q->filter.created_least, &q->filter.created_most);
}

static bool read_seconds(query *q, const char *text, double *out) {
  int64_t value;
  q->filter.timed = true;
  if (!read_count(text, 0, 1000000000000, &value)) return false;
  *out = (double)value;
  return true;
}

static bool read_least(query *q, const char *text, const char **needs) {
  *needs = "seconds, an integer from 0 on";
  return read_seconds(q, text, &q->filter.seconds_least);
}

static bool read_most(query *q, const char *text, const char **needs) {
  *needs = "seconds, an integer from 0 on";
  return read_seconds(q, text, &q->filter.seconds_most);
}

static bool read_parent(query *q, const char *text, const char **needs) {
  job_view view;
  *needs = "the id of a batch";
  if (jobs_find(q->service->jobs, q->x->owner, text, &view) != STORE_OK) return false;
  q->filter.has_parent = true;
  q->filter.parent = view.row.number;
  return true;
}

static const struct {
  const char *name;
  reader *read;
  bool is_list; /* "a,b", or given once for each */
} arguments[] = {
    {"limit", read_limit, false},       {"offset", read_offset, false},
    {"type", read_type, true},          {"processID", read_process, true},
    {"status", read_status, true},      {"datetime", read_datetime, false},
    {"minDuration", read_least, false}, {"maxDuration", read_most, false},
    {"parent", read_parent, false},
};

enum { ARGUMENTS = sizeof arguments / sizeof *arguments, LIST_MAX = 512 };

static const char *argument(const exchange *x, int k, char room[LIST_MAX]) {
  return arguments[k].is_list ? http_argument_list(x, arguments[k].name, room, LIST_MAX)
                              : http_argument(x, arguments[k].name);
}

static bool read_query(exchange *x, query *q) {
  for (int k = 0; k < ARGUMENTS; k++) {
    char room[LIST_MAX];
    const char *needs = "", *text = argument(x, k, room);
    const int times = http_arguments(x, arguments[k].name);
    if (times > 1 && !arguments[k].is_list) {
      exchange_refuse(x, 400, "%s: is there %d times, needs to be there once", arguments[k].name,
                      times);
      return false;
    }
    if (text == NULL || arguments[k].read(q, text, &needs)) continue;
    exchange_refuse(x, 400, "%s: got \"%.100s\", needs %s", arguments[k].name, text, needs);
    return false;
  }
  return true;
}

/* ---- The document ---- */

typedef struct {
  emit *e;
  exchange *x;
  int64_t left; /* entries to show; one more than that was asked for */
  bool more;
} page;

static bool show(void *context, const job_row *row) {
  page *p = context;
  const job_view view = {.row = *row};
  p->more = p->left == 0;
  if (p->more) return false;
  p->left--;
  job_status_emit(p->e, &view, p->x->base, false, NULL);
  return true;
}

/* Appends text as it may stand in a query. */
static void escape(char *to, size_t size, const char *text) {
  size_t used = strlen(to);
  for (; *text != '\0' && used + 4 < size; text++) {
    const unsigned char c = (unsigned char)*text;
    const bool plain = isalnum(c) || strchr("-._~:,/", c) != NULL;
    used += (size_t)snprintf(to + used, size - used, plain ? "%c" : "%%%02X", c);
  }
}

/* The address of another page with the same filters. */
static void page_address(const exchange *x, const query *q, int64_t offset, char *text,
                         size_t size) {
  snprintf(text, size, "%s/jobs?limit=%lld&offset=%lld", x->base, (long long)q->filter.limit,
           (long long)offset);
  for (int k = 2; k < ARGUMENTS; k++) {
    char room[LIST_MAX];
    const char *value = argument(x, k, room);
    if (value == NULL) continue;
    const size_t used = strlen(text);
    snprintf(text + used, size - used, "&%s=", arguments[k].name);
    escape(text, size, value);
  }
}

static void emit_link(emit *e, const char *relation, const char *href) {
  emit_object(e);
  emit_key(e, "href");
  emit_text(e, href);
  emit_key(e, "rel");
  emit_text(e, relation);
  emit_key(e, "type");
  emit_text(e, "application/json");
  emit_end(e);
}

static void emit_pages(page *p, const query *q) {
  char text[8192];
  const int64_t offset = q->filter.offset, limit = q->filter.limit - 1;
  query plain = *q;
  plain.filter.limit = limit;
  emit_key(p->e, "links");
  emit_list(p->e);
  page_address(p->x, &plain, offset, text, sizeof text);
  emit_link(p->e, "self", text);
  if (p->more) {
    page_address(p->x, &plain, offset + limit, text, sizeof text);
    emit_link(p->e, "next", text);
  }
  if (offset > 0) {
    page_address(p->x, &plain, offset > limit ? offset - limit : 0, text, sizeof text);
    emit_link(p->e, "prev", text);
  }
  emit_end(p->e);
}

static void reply_emitted(exchange *x, emit *e) {
  size_t size = 0;
  char *text = emit_take_text(e, &size);
  if (text == NULL) {
    exchange_refuse(x, 503, "out of memory");
    return;
  }
  exchange_bytes(x, 200, media_type(MEDIA_JSON), text, size);
  negotiate_coding(x);
}

void job_list_serve(const service *s, exchange *x) {
  query q = {.service = s,
             .x = x,
             .filter = {.owner = x->owner,
                        .states = ~0u,
                        .created_most = INFINITY,
                        .seconds_most = INFINITY,
                        .now = unix_now(),
                        .limit = LIMIT}};
  if (!read_query(x, &q) || !negotiate_json(x)) return;
  page p = {.e = emit_new(EMIT_JSON), .x = x, .left = q.filter.limit++};
  if (p.e == NULL) {
    exchange_refuse(x, 503, "out of memory");
    return;
  }
  emit_object(p.e);
  emit_key(p.e, "jobs");
  emit_list(p.e);
  const store_result result = jobs_list(s->jobs, &q.filter, show, &p);
  emit_end(p.e);
  emit_pages(&p, &q);
  emit_end(p.e);
  if (result == STORE_OK) {
    reply_emitted(x, p.e);
  } else {
    job_refuse_store(x, result);
  }
  emit_free(&p.e);
}
