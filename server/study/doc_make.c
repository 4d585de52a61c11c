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

bool doc_add_members(task *t, const doc *from, doc *into) {
  for (const doc *m = from->child; m; m = m->next) {
    bool is_known = doc_member(into, m->key);
    if (!is_known && !doc_append(into, doc_make_alias(t, m->key, m))) return false;
  }
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

/* Means */

/* The numbers of a mean; they are ours to change. */
static double *values_of(doc *mean) {
  return (double *)mean->data;
}

/* The documents may go before their mean does, keys too. */
static doc *begin(task *t, const doc *d) {
  doc *mean = make(t, NULL, d);
  if (!mean || !d->key) return mean;
  mean->key = doc_arena_copy(t->arena, d->key, strlen(d->key));
  if (!mean->key) (void)sct_fail(&t->error, SCT_E_MEMORY, -1, "out of memory");
  return mean->key ? mean : NULL;
}

static doc *begin_numbers(task *t, const doc *d) {
  double *copy = task_take(t, d->count, sizeof *copy);
  doc *mean = copy ? begin(t, d) : NULL;
  if (!mean) return NULL;
  if (d->count) memcpy(copy, d->data, (size_t)d->count * sizeof *copy);
  mean->data = copy;
  return mean;
}

static doc *begin_object(task *t, const doc *d) {
  doc *mean = begin(t, d);
  if (mean) mean->child = NULL;
  if (mean) mean->count = 0;
  for (const doc *m = d->child; m && mean; m = m->next) {
    doc *member = doc_mean_begin(t, m);
    if (t->error.code) return NULL;
    if (member) doc_append(mean, member);
  }
  return mean;
}

doc *doc_mean_begin(task *t, const doc *d) {
  if (d->kind == DOC_NUMBER) return begin(t, d);
  if (d->kind == DOC_NUMBERS) return begin_numbers(t, d);
  return d->kind == DOC_OBJECT ? begin_object(t, d) : NULL;
}

void doc_mean(doc *mean, const doc *d, int64_t k) {
  if (!d || d->kind != mean->kind) return;
  if (mean->kind == DOC_NUMBER) mean->number += (d->number - mean->number) / (double)k;
  if (mean->kind == DOC_NUMBERS && mean->count == d->count) {
    double *value = values_of(mean);
    for (int64_t i = 0; i < mean->count; i++) value[i] += (d->data[i] - value[i]) / (double)k;
  }
  if (mean->kind != DOC_OBJECT) return;
  for (const doc *m = mean->child; m; m = m->next) doc_mean((doc *)m, doc_member(d, m->key), k);
}
