#include "by_href.h"

#include <stdlib.h>
#include <string.h>

#include "base64.h"
#include "data_url.h"
#include "doc_tree.h"
#include "inflate.h"
#include "result.h"
#include "utf8.h"

void by_href_clear(by_href *b) {
  doc_arena_free(&b->arena);
}

/* One value */

/* Too much for a limit or for memory: no fault of the syntax, so 422 and not 400. */
static void refuse_size(task *t, const item *at, const char *why) {
  char *pointer = task_take(t, PROBLEM_POINTER, 1);
  if (t->error.code) return;
  item_pointer(at, pointer);
  t->blame = pointer;
  (void)sct_fail(&t->error, SCT_E_LIMIT, -1, "a value by reference: %s", why);
}

/* Does `at` stand in an input that is a text? */
static bool is_for_text(const task *t, const item *at) {
  const by_href *b = t->by_href;
  while (at && at->up != b->inputs) at = at->up;
  for (int k = 0; at && at->key && b->texts && b->texts[k]; k++) {
    if (!strcmp(b->texts[k], at->key)) return true;
  }
  return false;
}

static const doc *text_of(task *t, const item *at, const void *bytes, size_t size) {
  doc_tree tree;
  if (utf8_prefix(bytes, size) < size) {
    complain(t, at, "leads to bytes that are not UTF-8, needs a text");
    return NULL;
  }
  if (doc_tree_start(&tree, t->by_href->arena, 1) && doc_tree_text(&tree, bytes, size)) {
    return tree.root;
  }
  (void)sct_fail(&t->error, SCT_E_MEMORY, -1, "no memory for a text");
  return NULL;
}

/* Reads bytes of any of our types. NULL with a complaint at `at`. */
static const doc *decode(task *t, const item *at, media form, const void *bytes, size_t size) {
  const doc_limits most = {(int)t->limits->depth, t->limits->nodes, t->limits->decoded_bytes / 2};
  doc_arena *arena = NULL;
  doc_error error;
  if (form == MEDIA_CSV && is_for_text(t, at)) return text_of(t, at, bytes, size);
  const doc *value = doc_from(form, bytes, size, &most, &arena, &error);
  if (!value && error.too_large) {
    refuse_size(t, at, error.text);
    doc_arena_free(&arena);
    return NULL;
  }
  if (!value) complain(t, at, "leads to %s that cannot be read: %s", media_type(form), error.text);
  if (value) doc_arena_adopt(t->by_href->arena, &arena);
  doc_arena_free(&arena);
  return value;
}

static const doc *read_data_url(task *t, const item *at) {
  unsigned char *bytes;
  const char *why;
  const doc *value = NULL;
  size_t size = 0;
  media form;
  if (data_url_read(at->doc->text, &form, &bytes, &size, &why)) {
    value = decode(t, at, form, bytes, size);
  } else if (why) {
    complain(t, at, "is a data: URL that %s", why);
  } else {
    (void)sct_fail(&t->error, SCT_E_MEMORY, -1, "no memory for a data: URL");
  }
  free(bytes);
  return value;
}

/* One output of a stored result. */
static const doc *pick(task *t, const item *at, const doc *stored, const char *name) {
  result r;
  const bool is_read = result_read(t, stored, &r);
  const result_output *o = is_read ? result_find(&r, name) : NULL;
  if (!is_read) t->error = (sct_error){0}; /* it is this request's fault only that it asks */
  if (!o) complain(t, at, "leads to results without an output \"%.60s\"", name);
  return o ? o->value : NULL;
}

/* What was fetched, its content coding undone. */
static const doc *read_fetched(task *t, const item *at, const ask_fetched *got) {
  const size_t most = (size_t)t->limits->decoded_bytes;
  void *plain = NULL;
  size_t size = got->size;
  if (got->coding != CODING_IDENTITY) {
    inflate_status status = inflate_bytes(got->coding, got->bytes, got->size, most, &plain, &size);
    if (status == INFLATE_MEMORY || status == INFLATE_TOO_LARGE) {
      refuse_size(t, at, inflate_text(status));
      return NULL;
    }
    if (status != INFLATE_OK) {
      complain(t, at, "leads to a body of which %s", inflate_text(status));
      return NULL;
    }
  }
  if (size > most) {
    refuse_size(t, at, "more bytes than decoded-bytes allows");
    free(plain);
    return NULL;
  }
  const doc *value = decode(t, at, got->media, plain ? plain : got->bytes, size);
  free(plain);
  return value && *got->output ? pick(t, at, value, got->output) : value;
}

static const doc *fetch(task *t, const item *at) {
  const ask_calls *calls = t->by_href->calls;
  ask_fetched got = {.status = 404};
  const doc *value = NULL;
  if (strlen(at->doc->text) >= IPC_URL) {
    complain(t, at, "has %zu characters, at most %d are allowed", at->doc->length, IPC_URL - 1);
    return NULL;
  }
  if (!calls->fetch) {
    complain(t, at, "leads elsewhere, needs a data: URL: nothing is fetched here");
    return NULL;
  }
  calls->fetch(calls->context, at->doc->text, &got);
  if (got.status == 200) {
    value = read_fetched(t, at, &got);
  } else if (got.status == 500 || got.status == 503) { /* the service lacks something: no 400 */
    (void)sct_fail(&t->error, SCT_E_CANCELLED, -1, "a value by reference %s", got.detail);
  } else {
    complain(t, at, "%s", got.detail);
  }
  if (calls->release) calls->release(calls->context, &got);
  return value;
}

/* All of them */

static href_entry *find(const by_href *b, const char *href, bool is_text) {
  href_entry *e = b->first;
  while (e && (e->is_text != is_text || strcmp(e->href, href))) e = e->next;
  return e;
}

static href_entry *add(task *t, const item *at) {
  by_href *b = t->by_href;
  if (!b->arena) b->arena = doc_arena_new();
  href_entry *e = b->arena ? doc_arena_take(b->arena, sizeof *e) : NULL;
  char *href = e ? doc_arena_copy(b->arena, at->doc->text, at->doc->length) : NULL;
  if (!href) {
    (void)sct_fail(&t->error, SCT_E_MEMORY, -1, "no memory for a reference");
    return NULL;
  }
  *e = (href_entry){.next = b->first, .href = href, .is_text = is_for_text(t, at)};
  b->first = e;
  b->count++;
  return e;
}

static const doc *value_of(task *t, const item *at) {
  const char *text;
  if (!read_text(t, at, &text)) return NULL;
  href_entry *e = find(t->by_href, text, is_for_text(t, at));
  if (e && !e->value) complain(t, at, "leads to nothing, as said above");
  if (e) return e->value;
  if (t->by_href->count == HREFS_MAX) {
    complain(t, at, "is one of more than %d references", HREFS_MAX);
    return NULL;
  }
  e = add(t, at);
  if (!e) return NULL;
  e->value = data_url_is(text) ? read_data_url(t, at) : fetch(t, at);
  return e->value;
}

/* {"href": ...} and nothing but what a link has beside it. */
static bool is_link(const doc *d) {
  static const char *const members[] = {"href", "type", "rel", "title", "hreflang", NULL};
  const doc *href = doc_member(d, "href");
  if (!href) return false;
  for (const doc *m = d->child; m; m = m->next) {
    int k = 0;
    while (members[k] && strcmp(members[k], m->key)) k++;
    if (!members[k]) return false;
  }
  return true;
}

/* {"value": text in base64, "encoding": "base64", "mediaType": ...}: bytes within the request. */
static bool is_encoded(const doc *d) {
  const doc *value = doc_member(d, "value"), *encoding = doc_member(d, "encoding");
  bool is_base64 = encoding && encoding->kind == DOC_TEXT && !strcmp(encoding->text, "base64");
  return is_base64 && value && value->kind == DOC_TEXT;
}

/* What such bytes are. A text need not say it, nor be of a type that we know. */
static bool encoded_form(task *t, const item *it, media *form) {
  const item type = item_member(it, "mediaType");
  const char *name = "";
  if (type.doc && !read_text(t, &type, &name)) return false;
  if (media_find(name, form)) return true;
  if (is_for_text(t, it) && (*name == '\0' || !strncmp(name, "text/", 5))) {
    *form = MEDIA_CSV; /* bytes as they are */
    return true;
  }
  complain(
      t, &type, "%s, needs application/json, application/cbor, application/x-npy or text/csv",
      type.doc ? "is a media type that is unknown here" : "is missing and required for base64");
  return false;
}

static const doc *decode_within(task *t, const item *it, media form) {
  const item at = item_member(it, "value");
  long long size = 0;
  by_href *b = t->by_href;
  if (!b->arena) b->arena = doc_arena_new();
  unsigned char *bytes = b->arena ? base64_decode(at.doc->text, at.doc->length, &size) : NULL;
  const doc *value = NULL;
  if (!bytes) {
    (void)sct_fail(&t->error, SCT_E_MEMORY, -1, "no memory for a value in base64");
  } else if (size < 0) {
    complain(t, &at, "is no base64");
  } else {
    value = decode(t, &at, form, bytes, (size_t)size);
  }
  free(bytes);
  return value;
}

/* The value goes into the node of the link, which keeps its place among its siblings. Nodes of a
 * decoded body are its task's to change. */
static void replace(const doc *link, const doc *value) {
  doc *place = (doc *)link;
  const char *key = link->key;
  const doc *next = link->next;
  *place = *value;
  place->key = key;
  place->next = next;
  place->by_href = true;
}

/* Recursion as deep as the document. Values that came by reference are not searched again. */
static void resolve(task *t, const item *it) {
  if (is_link(it->doc)) {
    const item href = item_member(it, "href");
    const doc *value = value_of(t, &href);
    if (value) replace(it->doc, value);
    return;
  }
  if (is_encoded(it->doc)) {
    media form;
    const doc *value = encoded_form(t, it, &form) ? decode_within(t, it, form) : NULL;
    if (value) replace(it->doc, value);
    return;
  }
  bool is_container = it->doc->kind == DOC_OBJECT || it->doc->kind == DOC_LIST;
  int64_t index = 0;
  if (!is_container || it->doc->by_href) return;
  for (const doc *d = it->doc->child; d && !t->error.code; d = d->next, index++) {
    const item child = {.doc = d, .up = it, .key = d->key, .index = index};
    resolve(t, &child);
  }
}

bool by_href_resolve(task *t, const item *inputs, const char *const *texts) {
  const int before = t->complaints.found;
  if (inputs->doc && t->by_href) {
    t->by_href->inputs = inputs;
    t->by_href->texts = texts;
    resolve(t, inputs);
    t->by_href->inputs = NULL; /* it does not outlive this call */
  }
  return t->complaints.found == before && t->error.code == SCT_OK;
}
