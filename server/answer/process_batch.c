/* process_batch.c - many requests in one: a list of them, or one and a table of parameters. It only
 * checks and splits; the children are jobs of their own. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"
#include "cloud_input.h"
#include "doc_make.h"
#include "estimate.h"
#include "expression.h"
#include "process.h"

static const char *const inputs[] = {"requests", "request", "parameters", "cloud", NULL};

enum { CHILDREN_MAX = 10000 };

typedef struct {
  const process *process;
  const doc *body;                          /* its execute request */
  emit *bytes;                              /* the same in CBOR, references unresolved */
  char pointer[PROBLEM_POINTER], where[64]; /* where it comes from, for complaints */
  int64_t points, memory;
} child;

typedef struct {
  int64_t count;
  child *child; /* [count] */
} batch;

/* ---- Bodies ---- */

/* Which process a request asks for. NULL with a complaint. */
static const process *process_of(task *t, const item *request) {
  const item it = item_member(request, "process");
  const char *id = "solve";
  char room[SHOWN_MAX];
  if (!read_text(t, &it, &id)) return NULL;
  const process *p = process_find(id);
  if (p && !p->children) return p;
  complain(t, &it, "is \"%s\", needs the id of a process that is no batch", shown(id, room));
  return NULL;
}

/* The inputs of a child: its own, the shared cloud if it has none, and a row of parameters. */
static doc *make_inputs(task *t, const item *own, const doc *cloud, const doc *row) {
  doc *made = doc_make_object(t, "inputs"), *parameters = NULL;
  if (!made) return NULL;
  for (const doc *m = own->doc ? own->doc->child : NULL; m; m = m->next) {
    bool is_parameters = row && !strcmp(m->key, "parameters");
    if (!is_parameters && !doc_append(made, doc_make_alias(t, m->key, m))) return NULL;
  }
  if (cloud && !doc_member(made, "cloud")) doc_append(made, doc_make_alias(t, "cloud", cloud));
  if (!row) return made;
  parameters = doc_make_alias(t, "parameters", row);
  const item before = item_input(own, "parameters");
  if (parameters && before.doc && before.doc->kind == DOC_OBJECT) {
    doc_add_members(t, before.doc, parameters);
  }
  doc_append(made, parameters);
  return made;
}

/* Makes the body of one child and writes it. */
static bool make_body(task *t, const item *request, const doc *cloud, const doc *row, child *c) {
  static const char *const members[] = {"process", "inputs", "outputs", "response", NULL};
  static const char *const kept[] = {"outputs", "response"};
  const item own = item_member(request, "inputs");
  c->process = process_of(t, request);
  if (!read_object(t, request, members) || !read_object(t, &own, NULL) || !c->process) return false;
  doc *body = doc_make_object(t, NULL);
  bool made = body && doc_append(body, make_inputs(t, &own, cloud, row));
  for (int k = 0; k < 2 && made; k++) {
    const doc *m = doc_member(request->doc, kept[k]);
    if (m) made = doc_append(body, doc_make_alias(t, kept[k], m));
  }
  c->body = body;
  c->bytes = made && !t->error.code ? emit_new(EMIT_CBOR) : NULL;
  if (c->bytes) emit_doc(c->bytes, body);
  if (c->bytes && emit_ok(c->bytes)) return true;
  (void)sct_fail(&t->error, SCT_E_MEMORY, -1, "no memory for the requests of a batch");
  return false;
}

static bool take_children(task *t, const item *at, int64_t count, batch *b) {
  if (count < 1 || count > CHILDREN_MAX) {
    complain(t, at, "makes %lld requests, needs 1 to %d", (long long)count, CHILDREN_MAX);
    return false;
  }
  b->child = task_zeros(t, count, sizeof *b->child);
  if (b->child) b->count = count;
  return b->child;
}

static void split_list(task *t, const item *list, const doc *cloud, batch *b) {
  bool is_list = list->doc->kind == DOC_LIST;
  if (!is_list) complain(t, list, "is no list of requests");
  if (!is_list || !take_children(t, list, list->doc->count, b)) return;
  int64_t k = 0;
  for (const doc *d = list->doc->child; d && !t->error.code; d = d->next, k++) {
    const item request = item_element(list, d, k);
    item_pointer(&request, b->child[k].pointer);
    make_body(t, &request, cloud, NULL, &b->child[k]);
  }
}

/* ---- Tables ---- */

/* Rows of the table: all columns have as many numbers. -1 with complaints. */
static int64_t rows_of(task *t, const item *table) {
  int64_t rows = -1;
  if (!read_required(t, table) || !read_object(t, table, NULL)) return -1;
  if (!table->doc->child) complain(t, table, "has no parameter, needs one or more");
  for (const doc *m = table->doc->child; m; m = m->next) {
    const item column = {.doc = m, .up = table, .key = m->key};
    numbers values = {0};
    if (!read_numbers(t, &column, 1, &values)) return -1;
    if (rows < 0) rows = values.rows;
    if (values.rows == rows) continue;
    complain(t, &column, "has %lld values, needs %lld like the first", (long long)values.rows,
             (long long)rows);
    return -1;
  }
  return rows;
}

static doc *row_of(task *t, const doc *table, int64_t row) {
  doc *made = doc_make_object(t, "parameters");
  for (const doc *m = table->child; m && made; m = m->next) {
    if (!doc_append(made, doc_make_number(t, m->key, m->data[row]))) return NULL;
  }
  return made;
}

static void split_table(task *t, const item *request, const item *table, const doc *cloud,
                        batch *b) {
  const int64_t rows = rows_of(t, table);
  if (rows < 0 || !take_children(t, table, rows, b)) return;
  for (int64_t k = 0; k < rows && task_is_well(t); k++) {
    const doc *row = row_of(t, table->doc, k);
    if (!row) return;
    item_pointer(request, b->child[k].pointer);
    snprintf(b->child[k].where, sizeof b->child[k].where, "row %lld of parameters: ", (long long)k);
    make_body(t, request, cloud, row, &b->child[k]);
  }
}

/* ---- Checks ---- */

/* A child's complaints are the batch's, pointers and all. */
static void pass_complaints(task *t, const child *c, const task *own) {
  const problem *p = &own->complaints;
  for (int k = 0; k < p->count; k++) {
    char pointer[2 * PROBLEM_POINTER];
    snprintf(pointer, sizeof pointer, "%s%s", c->pointer, p->errors[k].pointer);
    pointer[PROBLEM_POINTER - 1] = '\0';
    problem_add(&t->complaints, pointer, "%s%s", c->where, p->errors[k].detail);
  }
  if (p->count == 0 && own->error.code) {
    problem_add(&t->complaints, c->pointer, "%s%s", c->where, own->error.text);
  }
}

/* Reads a child as its worker will. */
static void check_child(task *t, child *c) {
  task own = {.limits = t->limits, .work = t->work, .by_href = t->by_href};
  performance f = {0};
  own.arena = doc_arena_new();
  if (!own.arena) {
    (void)sct_fail(&t->error, SCT_E_MEMORY, -1, "no memory for a request of a batch");
    return;
  }
  stopwatch_start(&own.watch);
  perform_read(&own, c->process, c->body, &f);
  if (own.error.code == SCT_E_MEMORY || own.error.code == SCT_E_LIMIT) {
    t->error = own.error;
  } else if (task_is_well(&own)) {
    c->memory = estimate_run(&own, &f);
    c->points = own.cloud ? own.cloud->cloud.n : 0;
  } else {
    pass_complaints(t, c, &own);
  }
  perform_clear(&f);
  language_free(&own.language);
  doc_arena_free(&own.arena);
}

static void read_batch(task *t, const item *in, void *state) {
  batch *b = state;
  const item list = item_member(in, "requests"), request = item_member(in, "request");
  const item table = item_member(in, "parameters"), cloud = item_member(in, "cloud");
  if (list.doc && request.doc) complain(t, &request, "stands beside requests, needs one of both");
  if (list.doc && table.doc) complain(t, &table, "stands beside requests, needs request");
  if (!list.doc && !request.doc) complain(t, in, "has neither requests nor request");
  if (!task_is_well(t)) return;
  if (list.doc) split_list(t, &list, cloud.doc, b);
  if (request.doc) split_table(t, &request, &table, cloud.doc, b);
  const bool is_split = task_is_well(t);
  for (int64_t k = 0; is_split && k < b->count && !t->error.code; k++) {
    if (t->complaints.count < PROBLEM_ERRORS_MAX) check_child(t, &b->child[k]);
  }
}

static sct_status run_batch(task *t, unsigned wanted, void *state) {
  (void)wanted, (void)state;
  t->blame = "";
  return sct_fail(&t->error, SCT_E_ARGUMENT, -1,
                  "a batch is a job, needs a service that keeps them");
}

static void clear_batch(void *state) {
  batch *b = state;
  for (int64_t k = 0; k < b->count; k++) emit_free(&b->child[k].bytes);
}

static bool put_children(task *t, const void *state, grow_bytes *frames) {
  const batch *b = state;
  for (int64_t k = 0; k < b->count; k++) {
    const child *c = &b->child[k];
    size_t size;
    const void *bytes = emit_bytes(c->bytes, &size);
    ipc_frame head = {.kind = IPC_FRAME_CHILD,
                      .size = (int64_t)size,
                      .points = c->points,
                      .memory_bytes = c->memory};
    snprintf(head.process, sizeof head.process, "%s", c->process->id);
    if (!check_put(t, &head, bytes, frames)) return false;
  }
  return true;
}

const process process_batch = {
    .id = "batch",
    .inputs = inputs,
    .state_size = sizeof(batch),
    .read = read_batch,
    .run = run_batch,
    .clear = clear_batch,
    .children = put_children,
};
