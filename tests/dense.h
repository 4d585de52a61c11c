/* dense.h - small full matrices [n][n], the oracle of the sparse ones. */
#ifndef TESTS_DENSE_H
#define TESTS_DENSE_H

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scatter/csr.h"

/* The sparse matrix of the entries that are not zero. Aborts without memory. */
static inline sct_csr *dense_to_csr(const double *a, int64_t rows, int64_t columns) {
  sct_csr *m = NULL;
  int64_t entries = 0;
  for (int64_t k = 0; k < rows * columns; k++) entries += a[k] != 0;
  if (sct_csr_new(rows, columns, entries, &m, NULL) != SCT_OK) abort();
  int64_t k = 0;
  for (int64_t i = 0; i < rows; i++) {
    for (int64_t j = 0; j < columns; j++) {
      if (a[i * columns + j] == 0) continue;
      m->column[k] = (int32_t)j;
      m->value[k++] = a[i * columns + j];
    }
    m->start[i + 1] = k;
  }
  return m;
}

/* x = A^-1 b by elimination with pivoting, in long double. Returns 0 if a pivot is zero. */
static inline int dense_solve(const double *a, int n, const double *b, double *x) {
  long double *m = malloc(sizeof *m * (size_t)n * (size_t)(n + 1));
  int ok = m != NULL;
  for (int i = 0; ok && i < n; i++) {
    for (int j = 0; j < n; j++) m[i * (n + 1) + j] = a[i * n + j];
    m[i * (n + 1) + n] = b[i];
  }
  for (int k = 0; ok && k < n; k++) {
    int p = k;
    for (int i = k; i < n; i++) {
      if (fabsl(m[i * (n + 1) + k]) > fabsl(m[p * (n + 1) + k])) p = i;
    }
    ok = m[p * (n + 1) + k] != 0;
    for (int j = 0; ok && j <= n; j++) {
      const long double t = m[p * (n + 1) + j];
      m[p * (n + 1) + j] = m[k * (n + 1) + j];
      m[k * (n + 1) + j] = t;
    }
    for (int i = k + 1; ok && i < n; i++) {
      const long double f = m[i * (n + 1) + k] / m[k * (n + 1) + k];
      for (int j = k; j <= n; j++) m[i * (n + 1) + j] -= f * m[k * (n + 1) + j];
    }
  }
  for (int i = n - 1; ok && i >= 0; i--) {
    long double sum = m[i * (n + 1) + n];
    for (int j = i + 1; j < n; j++) sum -= m[i * (n + 1) + j] * (long double)x[j];
    x[i] = (double)(sum / m[i * (n + 1) + i]);
  }
  free(m);
  return ok;
}

#endif
