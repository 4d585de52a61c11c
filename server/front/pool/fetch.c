#include "fetch.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "data.h"
#include "gate.h"
#include "media.h"
#include "outbound.h"

/* What a worker waits for: the answer of another host, or that something is kept. */
typedef struct wish {
  struct wish *next, **at;
  fetches *owner;
  pool_task *task;
  outbound_call *call; /* NULL: none */
  data_filing *filing; /* NULL: none */
} wish;

struct fetches {
  const service *service;
  wish *first;
};

/* ---- Giving ---- */

static void refuse(fetches *f, pool_task *t, int status, const char *format, ...)
    __attribute__((format(printf, 4, 5)));
static void refuse(fetches *f, pool_task *t, int status, const char *format, ...) {
  ipc_given given = {.status = status};
  va_list list;
  va_start(list, format);
  vsnprintf(given.detail, sizeof given.detail, format, list);
  va_end(list);
  pool_give(f->service->pool, t, &given, -1);
}

static void refuse_down(fetches *f, pool_task *t) {
  refuse(f, t, 503, "cannot be read: the database does not answer");
}

/* Gives a descriptor, which is closed. */
static void give(fetches *f, pool_task *t, ipc_given given, int fd) {
  if (fd < 0) {
    const int status = store_result_of(errno) == STORE_DOWN ? 503 : 500;
    refuse(f, t, status, "cannot be opened: %s", strerror(errno));
    return;
  }
  given.status = 200;
  pool_give(f->service->pool, t, &given, fd);
  close(fd);
}

/* ---- Our own ---- */

static void give_data(fetches *f, pool_task *t, const char *id) {
  data_row row;
  media form;
  const store_result found = data_find(f->service->data, pool_owner(t), id, &row);
  if (found == STORE_DOWN) {
    refuse_down(f, t);
  } else if (found != STORE_OK) {
    refuse(f, t, 404, "there is no data %.70s; it may have expired", id);
  } else if (!media_find(row.type, &form)) {
    refuse(f, t, 415, "is of media type %s, which cannot be read", row.type);
  } else {
    give(f, t, (ipc_given){.size = row.size, .media = form}, data_open(f->service->data, &row));
  }
}

static void give_result(fetches *f, pool_task *t, const char *id, const char *output) {
  const service *s = f->service;
  job_view view;
  ipc_given given = {.media = MEDIA_CBOR};
  const store_result found = jobs_find(s->jobs, pool_owner(t), id, &view);
  if (found == STORE_DOWN) {
    refuse_down(f, t);
  } else if (found != STORE_OK) {
    refuse(f, t, 404, "there is no job %.40s", id);
  } else if (view.row.state != JOB_SUCCESSFUL || view.row.parts > 0) {
    refuse(f, t, 404, "job %s has no results that could be used", id);
  } else {
    given.size = view.row.result_size;
    given.coding = (coding)view.row.result_coding;
    snprintf(given.output, sizeof given.output, "%s", output);
    give(f, t, given, jobs_result(s->jobs, &view.row));
  }
}

/* Takes `word` off the path. */
static bool take(const char **path, const char *word) {
  const size_t length = strlen(word);
  if (strncmp(*path, word, length) != 0) return false;
  *path += length;
  return true;
}

/* Takes a segment off the path. */
static bool take_segment(const char **path, char *room, size_t size) {
  const size_t length = strcspn(*path, "/?#");
  if (length == 0 || length >= size) return false;
  memcpy(room, *path, length);
  room[length] = '\0';
  *path += length;
  return true;
}

/* Gives what a path of ours leads to; false if it is none. */
static bool give_own(fetches *f, pool_task *t, const char *path) {
  char id[DATA_ID], output[IPC_NAME];
  if (take(&path, "/data/")) {
    if (!take_segment(&path, id, sizeof id) || *path != '\0') return false;
    give_data(f, t, id);
    return true;
  }
  if (!take(&path, "/jobs/") || !take_segment(&path, id, sizeof id)) return false;
  if (!take(&path, "/results/") || !take_segment(&path, output, sizeof output)) return false;
  if (*path != '\0') return false;
  give_result(f, t, id, output);
  return true;
}

/* The path of a URL, without that of public-url; NULL if it is no http URL and no path. */
static const char *path_of(const char *href, const char *public_url) {
  const size_t length = strlen(public_url);
  if (*href == '/') return href;
  if (length > 0 && strncmp(href, public_url, length) == 0 && href[length] == '/') {
    return href + length;
  }
  const bool is_http =
      strncasecmp(href, "http://", 7) == 0 || strncasecmp(href, "https://", 8) == 0;
  return is_http ? strchr(strstr(href, "://") + 3, '/') : NULL;
}

/* ---- Others ---- */

static wish *wish_new(fetches *f, pool_task *t) {
  wish *w = calloc(1, sizeof *w);
  if (w == NULL) return NULL;
  *w = (wish){.next = f->first, .at = &f->first, .owner = f, .task = t};
  if (f->first != NULL) f->first->at = &w->next;
  f->first = w;
  return w;
}

static void free_wish(wish *w) {
  if (w->next != NULL) w->next->at = w->at;
  *w->at = w->next;
  free(w);
}

static void cancel(wish *w) {
  if (w->call != NULL) outbound_cancel(w->call);
  data_forget(&w->filing);
  free_wish(w);
}

static void give_reply(fetches *f, pool_task *t, const outbound_reply *reply) {
  ipc_given given = {.size = reply->size};
  const char *type = *reply->type != '\0' ? reply->type : media_type(MEDIA_OCTETS);
  const char *how = *reply->coding != '\0' ? reply->coding : NULL;
  if (reply->status == 0) {
    refuse(f, t, reply->scarce ? 503 : 502, "cannot be fetched: %s", reply->why);
  } else if (reply->status != 200) {
    refuse(f, t, 502, "was answered with status %d, needs 200", reply->status);
  } else if (!media_of_body(type, &given.media) || !coding_of_body(how, &given.coding)) {
    refuse(f, t, 415, "is of media type \"%.60s\" (%.20s), needs JSON, CBOR, .npy or CSV", type,
           how != NULL ? how : coding_name(CODING_IDENTITY));
  } else {
    given.status = 200;
    pool_give(f->service->pool, t, &given, reply->fd);
  }
}

static void fetched(void *context, const outbound_reply *reply) {
  wish *w = context;
  fetches *f = w->owner;
  pool_task *t = w->task;
  free_wish(w);
  give_reply(f, t, reply);
  if (reply->fd >= 0) close(reply->fd);
}

static void fetch(fetches *f, pool_task *t, const char *url) {
  const parameters *set = f->service->set;
  const outbound_request request = {
      .url = url,
      .fields = {"Accept: application/json, application/cbor, application/x-npy, text/csv",
                 "Accept-Encoding: gzip, zstd"},
      .seconds = set->fetch_seconds,
      .most = set->fetch_bytes,
      .public_only = !outbound_allows(set->fetch_private, url)};
  wish *w = wish_new(f, t);
  if (w != NULL) w->call = outbound_start(f->service->outbound, &request, fetched, w);
  if (w != NULL && w->call != NULL) return;
  if (w != NULL) free_wish(w);
  refuse(f, t, 503, "out of memory");
}

/* ---- What workers want ---- */

static void find(fetches *f, pool_task *t, const char *href) {
  const parameters *set = f->service->set;
  const char *path = path_of(href, set->public_url);
  if (path != NULL && give_own(f, t, path)) return;
  if (path == NULL || *href == '/') {
    refuse(f, t, 404, "leads to nothing here, needs /data/ID, /jobs/ID/results/OUTPUT or a URL");
  } else if (!outbound_allows(set->fetch_hosts, href)) {
    refuse(f, t, 403, "leads to a host that is not allowed (fetch-hosts)");
  } else {
    fetch(f, t, href);
  }
}

static void give_kept(fetches *f, pool_task *t, data_result result, const data_row *row) {
  ipc_given given = {.status = 200};
  if (result == DATA_NEW || result == DATA_KNOWN || result == DATA_OTHER) {
    snprintf(given.href, sizeof given.href, "/data/%s", row->id);
    pool_give(f->service->pool, t, &given, -1);
  } else if (result == DATA_DOWN) {
    refuse_down(f, t);
  } else if (result == DATA_FAILED) {
    refuse(f, t, 500, "cannot be kept; the log knows more");
  } else {
    refuse(f, t, 507, "there is no room for %lld bytes (data-bytes, or the disk)",
           (long long)row->size);
  }
}

static void kept(void *self, data_result result, const data_row *row) {
  wish *w = self;
  fetches *f = w->owner;
  pool_task *t = w->task;
  free_wish(w);
  give_kept(f, t, result, row);
}

/* Takes the descriptor. */
static void keep(fetches *f, pool_task *t, const ipc_news *news, int fd) {
  wish *w = wish_new(f, t);
  if (w == NULL) {
    close(fd);
    refuse(f, t, 503, "out of memory");
    return;
  }
  const data_order order = {
      .owner = {pool_owner(t), gate_data_bytes(f->service->gate, pool_owner(t))},
      .type = news->type,
      .fd = fd,
      .size = (size_t)news->size,
      .done = kept,
      .self = w};
  data_add(f->service->data, &order, &w->filing);
}

static void wanted(void *self, pool_task *t, const ipc_news *news, int fd) {
  fetches *f = self;
  const bool is_nobody = gate_is_on(f->service->gate) && *pool_owner(t) == '\0';
  if (is_nobody) {
    refuse(f, t, 404, "leads to nothing here");
  } else if (news->kind == IPC_FETCH) {
    find(f, t, news->href);
  } else {
    keep(f, t, news, fd);
    return;
  }
  if (fd >= 0) close(fd);
}

static void ended(void *self, pool_task *t) {
  fetches *f = self;
  for (wish *w = f->first, *next; w != NULL; w = next) {
    next = w->next;
    if (w->task == t) cancel(w);
  }
}

fetches *fetches_new(const service *s) {
  fetches *f = calloc(1, sizeof *f);
  if (f == NULL) return NULL;
  f->service = s;
  pool_on_values(s->pool, &(pool_values){f, wanted, ended});
  return f;
}

void fetches_free(fetches **f) {
  if (*f == NULL) return;
  for (wish *w = (*f)->first, *next; w != NULL; w = next) {
    next = w->next;
    cancel(w);
  }
  pool_on_values((*f)->service->pool, &(pool_values){0});
  free(*f);
  *f = NULL;
}
