#include "scatter/csr.h"

#include <math.h>

#include "alloc.h"

sct_status sct_csr_new(int64_t rows, int64_t columns, int64_t entries, sct_csr **matrix,
                       sct_error *err) {
  sct_csr *a = NULL;
  sct_status status = sct_alloc_zero(&a, 1, sizeof *a, err);
  if (status != SCT_OK) goto done;
  a->rows = rows;
  a->columns = columns;
  status = sct_alloc_zero(&a->start, rows + 1, sizeof *a->start, err);
  if (status != SCT_OK) goto done;
  status = sct_alloc(&a->column, entries, sizeof *a->column, err);
  if (status != SCT_OK) goto done;
  status = sct_alloc(&a->value, entries, sizeof *a->value, err);
done:
  if (status != SCT_OK) sct_csr_free(&a);
  *matrix = a;
  return status;
}

void sct_csr_free(sct_csr **matrix) {
  sct_csr *a = *matrix;
  if (a == NULL) return;
  sct_release(&a->start);
  sct_release(&a->column);
  sct_release(&a->value);
  sct_release(matrix);
}

int64_t sct_csr_entries(const sct_csr *matrix) {
  return matrix->start[matrix->rows];
}

void sct_csr_multiply(const sct_csr *a, const double *x, double *y) {
  for (int64_t i = 0; i < a->rows; i++) {
    double sum = 0;
    for (int64_t k = a->start[i]; k < a->start[i + 1]; k++) sum += a->value[k] * x[a->column[k]];
    y[i] = sum;
  }
}

void sct_csr_multiply_add(const sct_csr *a, double factor, const double *x, double *y) {
  sct_csr_multiply_add_by(a, factor, x, y, 1);
}

void sct_csr_multiply_add_by(const sct_csr *a, double factor, const double *x, double *y,
                             int threads) {
  enum { WORTH = 10000 }; /* rows for which a thread is worth its start */
#ifdef _OPENMP
#pragma omp parallel for num_threads(threads) schedule(static) if (threads > 1 && a->rows > WORTH)
#endif
  for (int64_t i = 0; i < a->rows; i++) {
    double sum = 0;
    for (int64_t k = a->start[i]; k < a->start[i + 1]; k++) sum += a->value[k] * x[a->column[k]];
    y[i] += factor * sum;
  }
  (void)threads;
}

void sct_csr_multiply_transposed_add(const sct_csr *a, double factor, const double *x, double *y) {
  for (int64_t i = 0; i < a->rows; i++) {
    const double share = factor * x[i];
    for (int64_t k = a->start[i]; k < a->start[i + 1]; k++) y[a->column[k]] += share * a->value[k];
  }
}

void sct_csr_residual(const sct_csr *a, const double *x, const double *b, double *r,
                      double *scale) {
  for (int64_t i = 0; i < a->rows; i++) {
    double sum = b[i], size = fabs(b[i]);
    for (int64_t k = a->start[i]; k < a->start[i + 1]; k++) {
      const double term = a->value[k] * x[a->column[k]];
      sum -= term;
      size += fabs(term);
    }
    r[i] = sum;
    if (scale != NULL) scale[i] = size;
  }
}

void sct_csr_residual_transposed(const sct_csr *a, const double *x, const double *b, double *r,
                                 double *scale) {
  for (int64_t j = 0; j < a->columns; j++) {
    r[j] = b[j];
    if (scale != NULL) scale[j] = fabs(b[j]);
  }
  for (int64_t i = 0; i < a->rows; i++) {
    for (int64_t k = a->start[i]; k < a->start[i + 1]; k++) {
      const double term = a->value[k] * x[i];
      r[a->column[k]] -= term;
      if (scale != NULL) scale[a->column[k]] += fabs(term);
    }
  }
}
