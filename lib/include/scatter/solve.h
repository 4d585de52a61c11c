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
  int dim;                /* dimension of the cloud behind it, 0 if unknown */
  const char *method;     /* "auto", "direct", or a row of the table: "umfpack", "klu", "iterative";
                             NULL: auto */
  double backward_error;  /* direct: residual (below) without need of refinement; 0: rounding */
  double tolerance;       /* iterative: relative residual (below) to reach; 0: 1e-10 */
  int64_t max_iterations; /* iterative: of one solve; 0: 1000 */
  const char *preconditioner; /* iterative: "ilu", "amg"; NULL: as fits the matrix */
  const uint8_t *is_equation; /* [rows] 1: equation row, 0: condition row; NULL: all equations. Read
                                 by factor */
  bool guess;                 /* iterative: x of a solve comes with a guess */
  const sct_work *work;       /* iterative: hears the relative residual of every iteration, and may
                                 end it; progress is phase "solve". NULL: nobody */
} sct_solve_options;

enum { SCT_SOLVE_HISTORY = 64, SCT_SOLVE_REASON = 160 };

/* What a factorisation or solve has to tell. */
typedef struct {
  const char *method;          /* row of the table that did it */
  const char *ordering;        /* direct: fill-reducing ordering ("amd", "metis", ...), else NULL */
  const char *krylov;          /* iterative: "bicgstab", "gmres", else NULL */
  const char *preconditioner;  /* iterative: "ilu", "amg", else NULL */
  int64_t rows, nonzeros;      /* of A */
  int64_t factor_nonzeros;     /* of L + U; 0: there are none */
  int64_t peak_bytes;          /* memory of the factorisation, as the package counts it; 0: it
                                  does not (amg) */
  int iterations;              /* refinement steps, or iterations of an iterative solver */
  double reciprocal_condition; /* 1 / || |A^-1| |A| e ||_inf, Skeel's, estimated (exact where
                                  A^-1 >= 0, else rarely off by 3); rows may be scaled at will;
                                  0: not known (iterative) */
  double residual;             /* max_i |b - A x|_i / (|b| + |A| |x|)_i after the last solve; the
                                  relative error of x is about residual / reciprocal_condition */
  double relative_residual;    /* iterative: |D (b - A x)| / |D b| of the last x itself, Euclidean
                                  norms, D A with a unit diagonal */
  double seconds_factor, seconds_solve; /* elapsed, analysis within the first factor */
  /* iterative: relative residual after iterations 0, history_every, 2 history_every, ... of the
   * last solve, as the method goes on computing it */
  double history[SCT_SOLVE_HISTORY];
  int history_count, history_every;
  char
      fallback[SCT_SOLVE_REASON]; /* why a direct solver did what was to be iterated; "": nothing */
} sct_solve_report;

typedef struct sct_solver sct_solver; /* opaque; borrows the matrix until the next factor */

/* Has the packages take now what they keep for good: OpenBLAS some 130 MB of address space, for
 * which it waits forever where there is none; PETSc what sct_solver_load_iterative says. For a
 * process whose address space is limited, or that is to give up the right to open files or to start
 * threads, at its start. Proof: http.faults, http.sandbox */
void sct_solver_prepare(void);

/* Is the iterative solver there? It is PETSc, which is loaded at the first call (0.1 s, 270 MB of
 * address space, 10 MB of memory of its own): SCT_E_ARGUMENT if this library was built without or
 * it is not installed, SCT_E_MEMORY. Proof: unit.solve_petsc */
SCT_NODISCARD sct_status sct_solver_load_iterative(sct_error *err);

/* Will a system of so many rows be iterated with, whatever its entries? For estimates of memory.
 * Options NULL: auto. Proof: unit.solve_petsc */
bool sct_solver_iterates(const sct_solve_options *options, int64_t rows);

/* Names of the table's rows, NULL past the end: the direct ones, then "iterative". */
const char *sct_solver_name(int k);

/* Analyses the pattern of `a` (square, sorted rows) and chooses the solver; options NULL: auto.
 *   direct = klu for dim 1, below 400 rows for dim 3, below 1000 else; above umfpack, with METIS
 * for dim 3 from 3000 rows, with AMD else auto   = iterative, if it is there, from 3000 rows for
 * dim 3, from 20 000 for dim 2 (100 000 if convection dominates, or the diagonal); else direct
 *   iterative = BiCGStab with ILU(0) or BoomerAMG (solve_policy.h)
 * with measurements in tests/bench/bench_solve.md. auto looks at the values of some rows, nothing
 * else does. *solver is NULL on failure. SCT_E_ARGUMENT (not square, no rows, columns not
 * ascending, unknown method, an iterative one that is not there), SCT_E_LIMIT (2^31 entries),
 * SCT_E_MEMORY, SCT_E_SINGULAR where the package sees that the pattern alone makes it so (else
 * factor says it). Proof: unit.solve, unit.solve_petsc, fault.solve */
SCT_NODISCARD sct_status sct_solver_analyse(const sct_csr *a, const sct_solve_options *options,
                                            sct_solver **solver, sct_error *err);

/* Factors the values of `a`, whose pattern must be the analysed one (else SCT_E_ARGUMENT); called
 * again it replaces the factors, also on failure. `a` is borrowed until the next factor or free,
 * for residuals. Rows are scaled before. A zero row or pivot, or a reciprocal condition below
 * 1e-14, is SCT_E_SINGULAR with err->point = -1; the caller, who knows the points, adds the cause.
 * SCT_E_NOT_FINITE, SCT_E_MEMORY. Cost: the factorisation and two solves, which estimate the
 * condition. The iterative solver makes its preconditioner here, and sees neither zero pivots nor
 * the condition: a singular matrix is up to the caller (sct_system_explain) or to the fallback.
 * Proof: unit.solve, fault.solve */
SCT_NODISCARD sct_status sct_solver_factor(sct_solver *solver, const sct_csr *a, sct_error *err);

/* x = A^-1 b, or A^-T b if `transposed`; one step of iterative refinement where the backward error
 * is above options.backward_error, kept if it lowers it. b [rows], x [rows] out (in and out with
 * options.guess), not overlapping. The iterative solver (transposed: always with ILU) goes on until
 * the residual of x itself meets the tolerance; where it stagnates, breaks down or runs out of
 * iterations, a direct one takes over for good (report->fallback says why), up to 200 000 rows for
 * dim 3 and 3 000 000 else: above, SCT_E_CONVERGENCE. SCT_E_ARGUMENT (nothing factored),
 * SCT_E_NOT_FINITE (b); a result that is not finite is SCT_E_SINGULAR. Proof: unit.solve */
SCT_NODISCARD sct_status sct_solver_solve(sct_solver *solver, const double *b, bool transposed,
                                          double *x, sct_error *err);

/* Report of the last factor and solve; valid as long as the solver. */
const sct_solve_report *sct_solver_report(const sct_solver *solver);
void sct_solver_free(sct_solver **solver);

#ifdef __cplusplus
}
#endif
#endif
