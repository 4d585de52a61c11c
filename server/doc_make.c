#include "doc_make.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "doc_tree.h"

/* Making */

static doc *make(task *t, const char *key, const doc *like) {
  doc *d = task_take(t, 1, sizeof *d);
  if (!d) return NULL;
  *d = *like;
  d->key = key;
  d->next = NULL;
  return d;
}

doc *doc_make_object(task *t, const char *key) {
  const doc empty = {.kind = DOC_OBJECT};
  return make(t, key, &empty);
}

doc *doc_make_number(task *t, const char *key, double value) {
  const doc number = {.kind = DOC_NUMBER, .number = value};
  return make(t, key, &number);
}

doc *doc_make_numbers(task *t, const char *key, const double *value, int64_t n) {
  double *copy = task_take(t, n, sizeof *copy);
  const doc numbers = {.kind = DOC_NUMBERS, .count = n, .rank = 1, .shape = {n}, .data = copy};
  if (!copy) return NULL;
  if (n) memcpy(copy, value, (size_t)n * sizeof *copy);
  return make(t, key, &numbers);
}

doc *doc_make_alias(task *t, const char *key, const doc *d) {
  return make(t, key, d);
}

bool doc_append(doc *container, doc *child) {
  if (!child) return false;
  const doc **link = &container->child;
  while (*link) link = (const doc **)&(*link)->next;
  *link = child;
  container->count++;
  return true;
}

/* Pointers */

/* The child of `d` that the first step of *pointer names; *pointer moves past it. */
static const doc *step(const doc *d, const char **pointer) {
  char key[64];
  const char *from = *pointer + 1;
  size_t length = strcspn(from, "/");
  *pointer = from + length;
  if (length >= sizeof key) return NULL;
  memcpy(key, from, length);
  key[length] = '\0';
  return d->kind == DOC_LIST ? doc_at(d, strtoll(key, NULL, 10)) : doc_member(d, key);
}

const doc *doc_at_pointer(const doc *d, const char *pointer) {
  while (d && *pointer == '/') d = step(d, &pointer);
  return d;
}

double doc_number_at(const doc *d, const char *pointer) {
  while (d && *pointer == '/' && d->kind != DOC_NUMBERS) d = step(d, &pointer);
  if (d && d->kind == DOC_NUMBER && !*pointer) return d->number;
  if (!d || d->kind != DOC_NUMBERS || d->rank != 1 || *pointer != '/') return NAN;
  int64_t k = strtoll(pointer + 1, NULL, 10);
  return k >= 0 && k < d->count ? d->data[k] : NAN;
}

/* Sums */

/* The numbers of a sum; they are ours to change. */
static double *values_of(doc *sum) {
  return (double *)sum->data;
}

/* What is summed may go before the sum does, keys too. */
static doc *begin(task *t, const doc *d) {
  doc *sum = make(t, NULL, d);
  if (!sum || !d->key) return sum;
  sum->key = doc_arena_copy(t->arena, d->key, strlen(d->key));
  if (!sum->key) (void)sct_fail(&t->error, SCT_E_MEMORY, -1, "out of memory");
  return sum->key ? sum : NULL;
}

static doc *begin_numbers(task *t, const doc *d) {
  double *copy = task_take(t, d->count, sizeof *copy);
  doc *sum = copy ? begin(t, d) : NULL;
  if (!sum) return NULL;
  if (d->count) memcpy(copy, d->data, (size_t)d->count * sizeof *copy);
  sum->data = copy;
  return sum;
}

static doc *begin_object(task *t, const doc *d) {
  doc *sum = begin(t, d);
  if (sum) sum->child = NULL;
  if (sum) sum->count = 0;
  for (const doc *m = d->child; m && sum; m = m->next) {
    doc *member = doc_sum_begin(t, m);
    if (t->error.code) return NULL;
    if (member) doc_append(sum, member);
  }
  return sum;
}

doc *doc_sum_begin(task *t, const doc *d) {
  if (d->kind == DOC_NUMBER) return begin(t, d);
  if (d->kind == DOC_NUMBERS) return begin_numbers(t, d);
  return d->kind == DOC_OBJECT ? begin_object(t, d) : NULL;
}

void doc_add(doc *sum, const doc *d) {
  if (!d || d->kind != sum->kind) return;
  if (sum->kind == DOC_NUMBER) sum->number += d->number;
  if (sum->kind == DOC_NUMBERS && sum->count == d->count) {
    for (int64_t k = 0; k < sum->count; k++) values_of(sum)[k] += d->data[k];
  }
  if (sum->kind != DOC_OBJECT) return;
  for (const doc *m = sum->child; m; m = m->next) doc_add((doc *)m, doc_member(d, m->key));
}

void doc_scale(doc *sum, double factor) {
  if (sum->kind == DOC_NUMBER) sum->number *= factor;
  if (sum->kind == DOC_NUMBERS) {
    for (int64_t k = 0; k < sum->count; k++) values_of(sum)[k] *= factor;
  }
  if (sum->kind != DOC_OBJECT) return;
  for (const doc *m = sum->child; m; m = m->next) doc_scale((doc *)m, factor);
}
