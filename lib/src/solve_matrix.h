/* solve_matrix.h - the copy of a matrix that the packages see: D A, by columns or by rows.
 *
 * By columns for direct solvers, which substitute with A up to a third faster than with its
 * transpose: D scales rows by powers of two, without rounding, to a largest entry in [1/2, 1);
 * condition rows and equation rows differ by a factor h or more, and not every package scales.
 *
 * By rows for iterative ones: D makes the diagonal of equation rows 1 and that of condition rows
 * 1/4. Multigrid weighs rows when it adds them up to coarse ones, and condition rows as heavy as
 * equation rows take it twenty times the iterations in three dimensions (bench_solve.md). */
#ifndef SCATTER_SOLVE_MATRIX_H
#define SCATTER_SOLVE_MATRIX_H

#include "scatter/csr.h"

typedef struct {
  int n;
  bool by_rows;
  int *start;       /* [n+1] */
  const int *index; /* [start[n]] rows of a column, or columns of a row, ascending */
  double *value;    /* [start[n]] ones until values are taken: packages look at what is not zero */
  double *scale;    /* [n] D */
  const sct_csr *source; /* by rows: A */
  int *row;              /* by columns: [start[n]] what index points at; by rows that is A's own */
  int *from;             /* by columns: [start[n]] entry of A behind each */
} sct_solve_matrix;

/* Copies the pattern of a square matrix with sorted rows; *m is zeroes before. SCT_E_MEMORY, what
 * was allocated is left to sct_solve_matrix_clear. */
SCT_NODISCARD sct_status sct_solve_matrix_pattern(sct_solve_matrix *m, const sct_csr *a,
                                                  bool by_rows, sct_error *err);

/* Takes the values; is_equation [n] may be NULL, and so it is by columns. By rows `a` is borrowed
 * until the next call. SCT_E_ARGUMENT if the pattern is another (by rows: starts elsewhere, or is
 * not ascending), SCT_E_NOT_FINITE, SCT_E_SINGULAR for a row of zeroes. */
SCT_NODISCARD sct_status sct_solve_matrix_values(sct_solve_matrix *m, const sct_csr *a,
                                                 const uint8_t *is_equation, sct_error *err);

/* D of a row for iterative solvers, whose largest entry is `most`. */
double sct_solve_scale(double most, double diagonal, bool is_equation);
void sct_solve_matrix_clear(sct_solve_matrix *m);

#endif
