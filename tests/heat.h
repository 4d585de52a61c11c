/* heat.h - the smallest sct_system by hand: -mu phi'' + u phi' + k phi on [0, 1], n points a
 * spacing h apart, three-point differences, a condition at each end: equation i   (mu / h^2) (2
 * phi_i - phi_i-1 - phi_i+1) + (u / 2h) (phi_i+1 - phi_i-1) + k phi_i condition    c phi_0 + (phi_0
 * - phi_1) / h, likewise at the right end (Neumann: c = 0) Include cmocka.h before. */
#ifndef TESTS_HEAT_H
#define TESTS_HEAT_H

#include <stdlib.h>

#include "scatter/assemble.h"

typedef struct {
  int n;
  sct_condition left, right;
  double mu, velocity, reaction, coefficient; /* c, of Robin rows */
} heat;

static inline void heat_free(sct_system **system) {
  sct_system *s = *system;
  if (s == NULL) return;
  sct_csr_free(&s->matrix);
  sct_csr_free(&s->coupling);
  free(s->row_of);
  free(s->point_of);
  free(s->is_equation);
  free(s->load);
  free(s);
  *system = NULL;
}

static inline void *heat_memory(size_t count, size_t size) {
  void *memory = calloc(count, size);
  if (memory == NULL) abort();
  return memory;
}

/* Entry (row of the last started row, column of point j), kept ascending by the order of calls. */
static inline void heat_entry(sct_system *s, int64_t *k, int64_t *c, int j, double value) {
  if (s->row_of[j] >= 0) {
    s->matrix->column[*k] = s->row_of[j];
    s->matrix->value[(*k)++] = value;
  } else {
    s->coupling->column[*c] = (int32_t)j;
    s->coupling->value[(*c)++] = value;
  }
}

static inline sct_condition heat_condition(const heat *p, int i) {
  return i == 0 ? p->left : i == p->n - 1 ? p->right : SCT_INTERIOR;
}

static inline sct_system *heat_system(const heat *p) {
  const int n = p->n;
  const double h = 1.0 / (n - 1), d = p->mu / (h * h), a = p->velocity / (2 * h);
  sct_system *s = heat_memory(1, sizeof *s);
  s->n = n;
  s->row_of = heat_memory((size_t)n, sizeof *s->row_of);
  s->point_of = heat_memory((size_t)n, sizeof *s->point_of);
  s->is_equation = heat_memory((size_t)n, 1);
  s->load = heat_memory((size_t)n, sizeof *s->load);
  for (int i = 0; i < n; i++) {
    s->row_of[i] = -1;
    if (heat_condition(p, i) == SCT_DIRICHLET) continue;
    s->is_equation[s->unknowns] = heat_condition(p, i) == SCT_INTERIOR;
    s->point_of[s->unknowns] = i;
    s->row_of[i] = (int32_t)s->unknowns++;
  }
  if (sct_csr_new(s->unknowns, s->unknowns, 3 * n, &s->matrix, NULL) != SCT_OK) abort();
  if (sct_csr_new(s->unknowns, n, 3 * n, &s->coupling, NULL) != SCT_OK) abort();
  int64_t k = 0, c = 0;
  for (int64_t row = 0; row < s->unknowns; row++) {
    const int i = s->point_of[row];
    const double robin = heat_condition(p, i) == SCT_ROBIN ? p->coefficient : 0;
    if (s->is_equation[row]) {
      heat_entry(s, &k, &c, i - 1, -d - a);
      heat_entry(s, &k, &c, i, 2 * d + p->reaction);
      heat_entry(s, &k, &c, i + 1, -d + a);
    } else if (i == 0) {
      heat_entry(s, &k, &c, 0, robin + 1 / h);
      heat_entry(s, &k, &c, 1, -1 / h);
    } else {
      heat_entry(s, &k, &c, i - 1, -1 / h);
      heat_entry(s, &k, &c, i, robin + 1 / h);
    }
    s->matrix->start[row + 1] = k;
    s->coupling->start[row + 1] = c;
  }
  return s;
}

#endif
