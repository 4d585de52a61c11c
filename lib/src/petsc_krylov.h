/* petsc_krylov.h - a system iterated by PETSc, by one process or by many that each hold some of its
 * rows.
 *
 * A solve is a series of attempts. BiCGStab goes first, right-preconditioned, so that the residual
 * it sees is that of D A; the one it computes recursively drifts from the true one, so where it
 * ends the true one is looked at, and if that is too large BiCGStab starts again from there. Where
 * that stagnates GMRES tries with the other preconditioner; after that the caller falls back.
 *
 * With many processes every call is one of all of them; statuses are the same on all, but for
 * SCT_E_MEMORY, after which a process cannot go on with the others.
 */
#ifndef SCATTER_PETSC_KRYLOV_H
#define SCATTER_PETSC_KRYLOV_H

#include "petsc_calls.h"
#include "scatter/solve.h"
#include "solve_policy.h"

typedef struct {
  const petsc_calls *petsc;
  bool is_shared; /* by all processes that were started together */
  sct_solve_options options;
  sct_solve_traits traits;
  sct_preconditioner preconditioner;
  bool is_second;   /* GMRES, with the other preconditioner */
  int64_t rows;     /* on this process */
  int64_t nonzeros; /* of them */
  int blocks_count; /* of incomplete factors: processes */
  Mat matrix;       /* D A */
  Vec rhs, x;       /* arrays are put into them for a solve */
  KSP ksp;
  petsc_block *blocks; /* their memory */
  /* The squared norm of the true residual of x [rows], of the rows on this process. */
  double (*residual)(void *of, bool transposed, const double *b, const double *x);
  void *of;
  /* of the solve under way */
  sct_solve_report *report;
  double target, scale; /* norms of residual to reach, of the right-hand side */
  double best, best_at; /* least norm so far, and when it was last halved */
  int spent, limit;     /* iterations */
  bool transposed, cancelled;
} krylov;

/* Krylov method and preconditioner for k->matrix, in the place of those before: the first attempt,
 * or that of k->is_second. */
SCT_NODISCARD sct_status krylov_set_up(krylov *k, sct_solve_report *report, sct_error *err);

/* The first attempt's preconditioner for the traits, or the one asked for. */
sct_preconditioner krylov_first(const krylov *k);

/* Solves from x [rows], which is the best there is afterwards. `transposed`: by one process only.
 * SCT_E_CONVERGENCE, SCT_E_CANCELLED. */
SCT_NODISCARD sct_status krylov_solve(krylov *k, const double *b, bool transposed, double *x,
                                      sct_solve_report *report, sct_error *err);

/* A failure of PETSc's: one of memory leaves ruins, which are given up. */
SCT_NODISCARD sct_status krylov_failed(krylov *k, PetscErrorCode code, const char *what,
                                       sct_error *err);

/* Destroys all objects, or gives them up where that fails. */
void krylov_drop(krylov *k);

/* The sum over all processes. */
double krylov_sum(const krylov *k, double mine);

#endif
