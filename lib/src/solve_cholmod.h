/* solve_cholmod.h - symmetric positive matrices, factored once, solved with many times. */
#ifndef SCATTER_SOLVE_CHOLMOD_H
#define SCATTER_SOLVE_CHOLMOD_H

#include "scatter/csr.h"

typedef struct sct_cholesky sct_cholesky;

/* Factors a symmetric positive definite matrix, of which the entries column <= row count. *out is
 * NULL on failure. SCT_E_SINGULAR (not positive), SCT_E_MEMORY. One thread, the same bits always:
 * a simplicial factor, which for the five-point matrices it is meant for is no slower. */
SCT_NODISCARD sct_status sct_cholesky_build(const sct_csr *a, sct_cholesky **out, sct_error *err);

/* x = A^-1 b, [n] each; may be the same memory. Allocates nothing after the first. SCT_E_MEMORY. */
SCT_NODISCARD sct_status sct_cholesky_solve(sct_cholesky *c, const double *b, double *x,
                                            sct_error *err);
void sct_cholesky_free(sct_cholesky **c);

#endif
