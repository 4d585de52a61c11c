/* csr.h - sparse matrices, compressed by rows. Columns int32, as the solvers want them. */
#ifndef SCATTER_CSR_H
#define SCATTER_CSR_H

#include "scatter/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
  int64_t rows, columns;
  int64_t *start;  /* [rows+1] */
  int32_t *column; /* [start[rows]] ascending within a row, no column twice */
  double *value;   /* [start[rows]] */
} sct_csr;

/* Room for `entries` entries; start is zeroed, column and value are not. *matrix is NULL on
 * failure. SCT_E_MEMORY (also for sizes that no memory can hold). Proof: unit.csr */
SCT_NODISCARD sct_status sct_csr_new(int64_t rows, int64_t columns, int64_t entries,
                                     sct_csr **matrix, sct_error *err);
void sct_csr_free(sct_csr **matrix);
int64_t sct_csr_entries(const sct_csr *matrix);

/* y = A x. x [columns], y [rows] out, not overlapping. Proof: unit.csr */
void sct_csr_multiply(const sct_csr *a, const double *x, double *y);

/* y = y + factor * A x. Shapes as above. Proof: unit.csr */
void sct_csr_multiply_add(const sct_csr *a, double factor, const double *x, double *y);

/* The same by so many threads, to the last bit. Proof: unit.threads */
void sct_csr_multiply_add_by(const sct_csr *a, double factor, const double *x, double *y,
                             int threads);

/* y = y + factor * A^T x. x [rows], y [columns]. Proof: unit.csr */
void sct_csr_multiply_transposed_add(const sct_csr *a, double factor, const double *x, double *y);

/* r = b - A x and, where `scale` is not NULL, scale = |b| + |A| |x| by components, for the
 * backward error max |r| / scale (Oettli and Prager 1964). x [columns], b, r, scale [rows].
 * Proof: unit.csr */
void sct_csr_residual(const sct_csr *a, const double *x, const double *b, double *r, double *scale);

/* The same for the transpose: r = b - A^T x. x [rows], b, r, scale [columns]. Proof: unit.csr */
void sct_csr_residual_transposed(const sct_csr *a, const double *x, const double *b, double *r,
                                 double *scale);

#ifdef __cplusplus
}
#endif
#endif
