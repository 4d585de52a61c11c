/* solve.h - square sparse systems A x = b behind one table of solvers.
 *
 * analyse (once per pattern) -> factor (once per set of values) -> solve (once per right-hand
 * side). A factored solver solves with A and with its transpose.
 */
#ifndef SCATTER_SOLVE_H
#define SCATTER_SOLVE_H

#include "scatter/csr.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What the caller knows of a system that its entries do not say. */
typedef struct {
  int dim;            /* dimension of the cloud behind it, 0 if unknown */
  const char *method; /* "auto", "direct", or a row of the table: "umfpack", "klu"; NULL: auto */
  double tolerance;   /* backward error (residual below) at which a solve is content; 0: rounding */
} sct_solve_options;

/* What a factorisation or solve has to tell. */
typedef struct {
  const char *method;          /* row of the table that did it */
  const char *ordering;        /* fill-reducing ordering ("amd", "metis", ...) */
  int64_t rows, nonzeros;      /* of A */
  int64_t factor_nonzeros;     /* of L + U */
  int64_t peak_bytes;          /* memory of the factorisation, as the package counts it */
  int iterations;              /* refinement steps, or iterations of an iterative solver */
  double reciprocal_condition; /* 1 / || |A^-1| |A| e ||_inf, Skeel's, estimated (exact where
                                  A^-1 >= 0, else rarely off by 3); rows may be scaled at will */
  double residual;             /* max_i |b - A x|_i / (|b| + |A| |x|)_i after the last solve; the
                                  relative error of x is about residual / reciprocal_condition */
  double seconds_factor, seconds_solve; /* elapsed, analysis within the first factor */
} sct_solve_report;

typedef struct sct_solver sct_solver; /* opaque; borrows the matrix until the next factor */

/* Has the packages take now what they keep for good: OpenBLAS some 130 MB of address space, for
 * which it waits forever where there is none. For a process whose address space is limited, at its
 * start. Proof: http.faults */
void sct_solver_prepare(void);

/* Names of the table's rows, NULL past the end. */
const char *sct_solver_name(int k);

/* Analyses the pattern of `a` (square, sorted rows) and chooses the solver; options NULL: auto.
 * auto = klu for dim 1, below 400 rows for dim 3, below 1000 else; above umfpack, with METIS for
 * dim 3 from 3000 rows, with AMD else (measurements: tests/bench/bench_solve.md). The values are
 * not looked at. *solver is NULL on failure. SCT_E_ARGUMENT (not square, no rows, columns not
 * ascending, unknown method), SCT_E_LIMIT (2^31 entries), SCT_E_MEMORY, SCT_E_SINGULAR where the
 * package sees that the pattern alone makes it so (else factor says it). Proof: unit.solve,
 * fault.solve */
SCT_NODISCARD sct_status sct_solver_analyse(const sct_csr *a, const sct_solve_options *options,
                                            sct_solver **solver, sct_error *err);

/* Factors the values of `a`, whose pattern must be the analysed one (else SCT_E_ARGUMENT); called
 * again it replaces the factors, also on failure. `a` is borrowed until the next factor or free,
 * for residuals. Rows are scaled before. A zero row or pivot, or a reciprocal condition below
 * 1e-14, is SCT_E_SINGULAR with err->point = -1; the caller, who knows the points, adds the cause.
 * SCT_E_NOT_FINITE, SCT_E_MEMORY. Cost: the factorisation and two solves, which estimate the
 * condition. Proof: unit.solve, fault.solve */
SCT_NODISCARD sct_status sct_solver_factor(sct_solver *solver, const sct_csr *a, sct_error *err);

/* x = A^-1 b, or A^-T b if `transposed`; one step of iterative refinement where the backward error
 * is above the tolerance, kept if it lowers it. b [rows], x [rows] out, not overlapping.
 * SCT_E_ARGUMENT (nothing factored), SCT_E_NOT_FINITE (b); a result that is not finite is
 * SCT_E_SINGULAR. Proof: unit.solve */
SCT_NODISCARD sct_status sct_solver_solve(sct_solver *solver, const double *b, bool transposed,
                                          double *x, sct_error *err);

/* Report of the last factor and solve; valid as long as the solver. */
const sct_solve_report *sct_solver_report(const sct_solver *solver);
void sct_solver_free(sct_solver **solver);

#ifdef __cplusplus
}
#endif
#endif
