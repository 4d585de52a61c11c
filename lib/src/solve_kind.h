/* solve_kind.h - a row of the table of solvers: what a package has to offer to be one.
 *
 * solve.c, the front, has checked everything before a row is called: the matrix is square, its
 * pattern is the analysed one, its rows are scaled, all numbers are finite. A row only translates,
 * into the package's calls and back into sct_status.
 */
#ifndef SCATTER_SOLVE_KIND_H
#define SCATTER_SOLVE_KIND_H

#include "scatter/solve.h"
#include "solve_matrix.h"

typedef struct {
  const char *name;
  bool iterates;         /* wants the matrix by rows, ends where the tolerance is met */
  void (*prepare)(void); /* takes what the package keeps for good; NULL: nothing */
  /* Is the package there? NULL: always. SCT_E_ARGUMENT if not, SCT_E_MEMORY. */
  sct_status (*load)(sct_error *err);
  /* *state = what the package keeps of the pattern. Sets ordering in the report. */
  sct_status (*analyse)(const sct_solve_matrix *a, const sct_solve_options *options, void **state,
                        sct_solve_report *report, sct_error *err);
  /* Factors, replacing earlier factors. Sets factor_nonzeros and peak_bytes in the report.
   * SCT_E_SINGULAR on a zero pivot; SCT_E_CONVERGENCE if there can be no preconditioner. */
  sct_status (*factor)(void *state, const sct_solve_matrix *a, sct_solve_report *report,
                       sct_error *err);
  /* x = A^-1 b or A^-T b. Direct rows: with neither refinement nor allocation. Iterative ones set
   * iterations, history and relative_residual in the report; SCT_E_CONVERGENCE. */
  sct_status (*solve)(void *state, const sct_solve_matrix *a, const double *b, bool transposed,
                      double *x, sct_solve_report *report, sct_error *err);
  void (*free)(void *state); /* of analyse, never NULL */
} sct_solve_kind;

extern const sct_solve_kind sct_solve_umfpack, sct_solve_klu, sct_solve_petsc;

#endif
