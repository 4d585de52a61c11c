/* Large bytes on their way into a shared store. They are written as rows of `large` that belong to
 * no job, by another thread and over another connection; the row's transaction then only has to
 * rename them, which leaves the bytes where they are. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "log.h"
#include "loop.h"
#include "store_shared.h"
#include "store_sql.h"

enum { DRAFT = -1 }; /* their kind */
static const double pause_seconds = 1;

/* ---- The second connection ---- */

store *store_writer_new(const store *s, const char *url) {
  store *w = calloc(1, sizeof *w);
  if (w == NULL) return NULL;
  *w = (store){.door = s->door, .directory = -1, .files = -1, .data = -1, .lock = -1};
  w->url = strdup(url);
  if (w->url == NULL) store_writer_free(&w);
  return w;
}

void store_writer_free(store **w) {
  if (*w == NULL) return;
  sql_close(*w);
  free((*w)->url);
  free(*w);
  *w = NULL;
}

/* Is it there? It is waited for, but not again by those who come next. */
static bool is_there(store *w) {
  fault why;
  if (w->base != NULL && store_is_up(w)) return true;
  if (loop_now() < w->until) return false;
  sql_close(w);
  if (sql_open(w, w->url, &why)) return true;
  log_say(LOG_ERROR, "store", "there is no second connection: %s", why.text);
  w->until = loop_now() + pause_seconds;
  return false;
}

static store_result write_over(store *w, const char *draft, int fd, size_t size) {
  if (!is_there(w)) return STORE_DOWN;
  store_result result = store_begin(w);
  if (result == STORE_OK) result = store_add_large(w, draft, DRAFT, fd, size);
  return store_end(w, result);
}

/* ---- Drafts ---- */

void store_sign(store *s, const char *holder) {
  snprintf(s->holder, sizeof s->holder, "%s", holder);
}

void store_name_draft(store *s, char draft[STORE_DRAFT]) {
  snprintf(draft, STORE_DRAFT, "%s.%" PRId64, s->holder, ++s->drafts);
}

/* Twice, as the connection may have broken since it was last used. */
int store_write_draft(store *s, const char *draft, int fd, size_t size) {
  store_result result = write_over(s->writer, draft, fd, size);
  if (result == STORE_DOWN) result = write_over(s->writer, draft, fd, size);
  return store_errno(result);
}

store_result store_adopt(store *s, const char *draft, const char *owner, int which, int fd,
                         size_t size) {
  store_result result = store_drop_large(s, owner, which, which);
  if (result != STORE_OK) return result;
  sql_text(s, ADOPT_LARGE, ":draft", draft);
  sql_text(s, ADOPT_LARGE, ":owner", owner);
  sql_long(s, ADOPT_LARGE, ":kind", which);
  result = sql_change(s, ADOPT_LARGE);
  return result == STORE_NONE ? store_add_large(s, owner, which, fd, size) : result;
}

void store_drop_draft(store *s, const char *draft) {
  (void)store_drop_large(s, draft, DRAFT, DRAFT);
}
