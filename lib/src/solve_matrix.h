/* solve_matrix.h - the copy of a matrix that the packages see: D A by columns.
 *
 * D scales rows by powers of two, without rounding, to a largest entry in [1/2, 1): condition rows
 * and equation rows differ by a factor h or more, and not every package scales. Columns, because
 * the packages substitute with A up to a third faster than with its transpose. */
#ifndef SCATTER_SOLVE_MATRIX_H
#define SCATTER_SOLVE_MATRIX_H

#include "scatter/csr.h"

typedef struct {
  int n;
  int *start;    /* [n+1] */
  int *row;      /* [start[n]] ascending within a column */
  double *value; /* [start[n]] ones until values are taken: packages look at what is not zero */
  int *from;     /* [start[n]] entry of A behind each */
  double *scale; /* [n] D */
} sct_solve_matrix;

/* Copies the pattern of a square matrix with sorted rows; *m is zeroes before. SCT_E_MEMORY, what
 * was allocated is left to sct_solve_matrix_clear. */
SCT_NODISCARD sct_status sct_solve_matrix_pattern(sct_solve_matrix *m, const sct_csr *a,
                                                  sct_error *err);

/* Takes the values. SCT_E_ARGUMENT if the pattern is another, SCT_E_NOT_FINITE, SCT_E_SINGULAR for
 * a row of zeroes. */
SCT_NODISCARD sct_status sct_solve_matrix_values(sct_solve_matrix *m, const sct_csr *a,
                                                 sct_error *err);
void sct_solve_matrix_clear(sct_solve_matrix *m);

#endif
