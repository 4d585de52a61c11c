#include "doc_tree.h"

#include <string.h>

bool doc_tree_start(doc_tree *t, doc_arena *arena, int depth) {
  *t = (doc_tree){.arena = arena};
  t->open = doc_arena_take(arena, (size_t)depth * sizeof *t->open);
  return t->open != NULL;
}

/* Links a new node behind its elder sibling. */
static doc *add(doc_tree *t, doc_kind kind) {
  doc *d = doc_arena_take(t->arena, sizeof *d);
  if (d == NULL) return NULL;
  *d = (doc){.kind = kind, .key = t->key};
  t->key = NULL;
  if (t->depth == 0) {
    t->root = d;
    return d;
  }
  doc_level *level = &t->open[t->depth - 1];
  if (level->tail == NULL) {
    level->node->child = d;
  } else {
    level->tail->next = d;
  }
  level->tail = d;
  level->node->count++;
  return d;
}

bool doc_tree_open(doc_tree *t, doc_kind kind) {
  doc *d = add(t, kind);
  if (d == NULL) return false;
  t->open[t->depth++] = (doc_level){.node = d};
  return true;
}

void doc_tree_close(doc_tree *t) {
  t->depth--;
}

bool doc_tree_key(doc_tree *t, const char *key, size_t length) {
  t->key = doc_arena_copy(t->arena, key, length);
  return t->key != NULL;
}

bool doc_tree_null(doc_tree *t) {
  return add(t, DOC_NULL) != NULL;
}

bool doc_tree_bool(doc_tree *t, bool truth) {
  doc *d = add(t, DOC_BOOL);
  if (d != NULL) d->truth = truth;
  return d != NULL;
}

bool doc_tree_text(doc_tree *t, const char *text, size_t length) {
  const char *copy = doc_arena_copy(t->arena, text, length);
  doc *d = copy == NULL ? NULL : add(t, DOC_TEXT);
  if (d == NULL) return false;
  d->text = copy;
  d->length = length;
  return true;
}

bool doc_tree_number(doc_tree *t) {
  return add(t, DOC_NUMBER) != NULL;
}

bool doc_tree_numbers(doc_tree *t, int rank, const int64_t *shape) {
  doc *d = add(t, DOC_NUMBERS);
  if (d == NULL) return false;
  d->rank = rank;
  d->count = 1;
  for (int k = 0; k < rank; k++) {
    d->shape[k] = shape[k];
    d->count *= shape[k];
  }
  return true;
}

/* Recursion as deep as the document, which the decoder's limit bounds. Nodes are ours to change
 * until the decoder returns them. */
static const double *settle(doc *d, const double *values) {
  if (d->kind == DOC_NUMBER) {
    d->number = *values;
    return values + 1;
  }
  if (d->kind == DOC_NUMBERS) {
    d->data = values;
    return d->count == 0 ? values : values + d->count;
  }
  for (const doc *child = d->child; child != NULL; child = child->next) {
    values = settle((doc *)child, values);
  }
  return values;
}

void doc_tree_settle(doc_tree *t, const double *values) {
  settle(t->root, values);
}
