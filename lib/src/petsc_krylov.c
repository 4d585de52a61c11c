#include "petsc_krylov.h"

#include <limits.h>
#include <math.h>
#include <string.h>

#include "alloc.h"

enum { MAX_ITERATIONS = 1000, RESTARTS = 4, PATIENCE = 200 };
static const double TOLERANCE = 1e-10;

/* Gives up all objects, finished or not. */
static void abandon(krylov *k) {
  petsc_abandon(&k->blocks);
  k->ksp = NULL;
  k->matrix = NULL;
  k->rhs = k->x = NULL;
}

sct_status krylov_failed(krylov *k, PetscErrorCode code, const char *what, sct_error *err) {
  if (code == PETSC_ERR_MEM || petsc_ran_out()) {
    abandon(k);
    return sct_fail(err, SCT_E_MEMORY, -1, "no memory in %s of petsc", what);
  }
  return sct_fail(err, SCT_E_CONVERGENCE, -1, "%s of petsc: error %d, %s", what, (int)code,
                  petsc_complaint());
}

/* Destroys the Krylov method; it may need memory for that, which PETSc then keeps. */
static sct_status drop_ksp(krylov *k, sct_error *err) {
  petsc_own(NULL);
  const PetscErrorCode code = k->ksp == NULL ? 0 : k->petsc->KSPDestroy(&k->ksp);
  if (code == 0) return SCT_OK;
  abandon(k);
  return sct_fail(err, SCT_E_MEMORY, -1, "no memory to free a solver of petsc: error %d",
                  (int)code);
}

void krylov_drop(krylov *k) {
  if (drop_ksp(k, NULL) != SCT_OK) return;
  PetscErrorCode code = 0;
  if (k->matrix != NULL) code = k->petsc->MatDestroy(&k->matrix);
  if (code == 0 && k->rhs != NULL) code = k->petsc->VecDestroy(&k->rhs);
  if (code == 0 && k->x != NULL) code = k->petsc->VecDestroy(&k->x);
  if (code != 0) abandon(k);
}

/* ---- the preconditioner ---- */

/* Every other entry goes when the history is full. */
static void keep_history(sct_solve_report *r, double at, double relative) {
  if (r->history_count == SCT_SOLVE_HISTORY) {
    r->history_count /= 2;
    r->history_every *= 2;
    for (int64_t h = 0; h < r->history_count; h++) r->history[h] = r->history[2 * h];
  }
  if (at == (double)r->history_count * r->history_every) r->history[r->history_count++] = relative;
}

/* Residuals fall by factors, so the way to go is told by their logarithms. Nobody leaves an
 * iteration that others share. */
static bool is_wanted(const krylov *k, double norm) {
  const double way = log(norm / k->scale) / log(k->target / k->scale);
  sct_work_residual(k->options.work, norm / k->scale);
  return sct_work_report(k->options.work, "solve", fmin(fmax(way, 0), 1), NULL) == SCT_OK ||
         k->is_shared;
}

/* Called at the start of a solve and after each iteration: keeps the history, and ends the attempt
 * where the target is met, where nobody wants it any more, or where in PATIENCE iterations, or as
 * many as there were before, the norm was not halved. */
static PetscErrorCode watch(KSP ksp, PetscInt iteration, PetscReal norm, KSPConvergedReason *reason,
                            void *context) {
  krylov *k = context;
  const double at = k->spent + (double)iteration;
  (void)ksp;
  *reason = KSP_CONVERGED_ITERATING;
  keep_history(k->report, at, norm / k->scale);
  if (norm <= 0.5 * k->best) {
    k->best = norm;
    k->best_at = at;
  }
  k->cancelled = !is_wanted(k, norm);
  if (k->cancelled)
    *reason = KSP_DIVERGED_BREAKDOWN;
  else if (norm <= k->target)
    *reason = KSP_CONVERGED_RTOL;
  else if (!(norm <= 1e6 * k->scale))
    *reason = KSP_DIVERGED_DTOL;
  else if (at >= k->limit || at - k->best_at > fmax(PATIENCE, 0.5 * at))
    *reason = KSP_DIVERGED_ITS;
  return 0;
}

static const struct {
  const char *name, *prefix;
} preconditioners[] = {
    [SCT_ILU] = {"ilu", NULL},
    [SCT_AMG] = {"amg", PETSC_AMG},
    [SCT_AMG_AGGRESSIVE] = {"amg", PETSC_AMG_AGGRESSIVE},
};

static PetscErrorCode make_ksp(krylov *k) {
  const petsc_calls *p = k->petsc;
  const char *prefix = preconditioners[k->preconditioner].prefix;
  PC pc;
  PetscErrorCode code = p->KSPCreate(k->is_shared ? p->world : p->self, &k->ksp);
  if (code == 0) code = p->KSPSetOperators(k->ksp, k->matrix, k->matrix);
  if (code == 0) code = p->KSPSetType(k->ksp, k->is_second ? KSPGMRES : KSPBCGS);
  if (code == 0) code = p->KSPSetPCSide(k->ksp, PC_RIGHT);
  if (code == 0) code = p->KSPSetNormType(k->ksp, KSP_NORM_UNPRECONDITIONED);
  if (code == 0) code = p->KSPSetConvergenceTest(k->ksp, watch, k, NULL);
  if (code == 0) code = p->KSPGetPC(k->ksp, &pc);
  if (code == 0 && prefix == NULL) code = p->PCSetType(pc, k->is_shared ? PCBJACOBI : PCILU);
  if (code == 0 && prefix != NULL) code = p->KSPSetOptionsPrefix(k->ksp, prefix);
  if (code == 0 && prefix != NULL) code = p->KSPSetFromOptions(k->ksp);
  return code;
}

/* hypre does not survive where there is no memory, so that is looked for first: two and a half
 * times its entries is what it took at most, rows of 13 to 110 entries. */
static bool has_room_for_multigrid(const krylov *k) {
  const int64_t bytes = k->nonzeros * (int64_t)(sizeof(double) + sizeof(int));
  void *room = NULL;
  const bool found = sct_alloc(&room, 5 * bytes / 2 + (16 << 20), 1, NULL) == SCT_OK;
  sct_release(&room);
  return krylov_sum(k, !found) == 0;
}

/* Blocks of incomplete factors, one per process, are ILU(0) where there is one. */
static const char *name_of(const krylov *k) {
  const bool is_blocks = k->is_shared && k->preconditioner == SCT_ILU && k->blocks_count > 1;
  return is_blocks ? "block ilu" : preconditioners[k->preconditioner].name;
}

sct_status krylov_set_up(krylov *k, sct_solve_report *report, sct_error *err) {
  PCFailedReason reason = PC_NOERROR;
  PC pc;
  sct_status status = drop_ksp(k, err);
  if (status != SCT_OK) return status;
  petsc_own(&k->blocks);
  if (k->preconditioner != SCT_ILU && !has_room_for_multigrid(k)) k->preconditioner = SCT_ILU;
  PetscErrorCode code = make_ksp(k);
  if (code == 0) code = k->petsc->KSPSetUp(k->ksp);
  if (code == 0) code = k->petsc->KSPGetPC(k->ksp, &pc);
  if (code == 0) code = k->petsc->PCGetFailedReason(pc, &reason);
  if (code != 0) return krylov_failed(k, code, "preconditioner", err);
  report->krylov = k->is_second ? "gmres" : "bicgstab";
  report->preconditioner = name_of(k);
  report->factor_nonzeros = k->preconditioner == SCT_ILU ? k->nonzeros : 0;
  report->peak_bytes = report->factor_nonzeros * (int64_t)(sizeof(double) + sizeof(int));
  if (krylov_sum(k, reason != PC_NOERROR) == 0) return SCT_OK;
  return sct_fail(err, SCT_E_CONVERGENCE, -1, "the preconditioner %s cannot be made",
                  report->preconditioner);
}

sct_preconditioner krylov_first(const krylov *k) {
  const char *wanted = k->options.preconditioner;
  if (wanted == NULL) return sct_solve_preconditioner(&k->traits);
  return strcmp(wanted, "ilu") == 0 ? SCT_ILU : sct_solve_multigrid(&k->traits);
}

/* ---- a solve ---- */

double krylov_sum(const krylov *k, double mine) {
  const petsc_calls *p = k->petsc;
  double sum = mine;
  if (k->is_shared) (void)(p->MPI_Allreduce)(&mine, &sum, 1, p->number, p->sum, p->world);
  return sum;
}

static double norm(const krylov *k, const double *x) {
  double sum = 0;
  for (int64_t i = 0; i < k->rows; i++) sum += x[i] * x[i];
  return sqrt(krylov_sum(k, sum));
}

static double true_residual(const krylov *k, const double *b, const double *x) {
  return sqrt(krylov_sum(k, k->residual(k->of, k->transposed, b, x)));
}

/* One run of the Krylov method from x. */
static sct_status iterate(krylov *k, const double *b, double *x, sct_error *err) {
  const petsc_calls *p = k->petsc;
  PetscInt count = 0;
  k->best = INFINITY;
  k->best_at = k->spent;
  PetscErrorCode code = p->VecPlaceArray(k->rhs, b);
  if (code == 0) code = p->VecPlaceArray(k->x, x);
  if (code == 0) code = p->KSPSetInitialGuessNonzero(k->ksp, PETSC_TRUE);
  if (code == 0) code = (k->transposed ? p->KSPSolveTranspose : p->KSPSolve)(k->ksp, k->rhs, k->x);
  (void)p->VecResetArray(k->rhs);
  (void)p->VecResetArray(k->x);
  if (code == 0) code = p->KSPGetIterationNumber(k->ksp, &count);
  k->spent += (int)count;
  k->report->iterations = k->spent;
  if (k->cancelled) return sct_fail(err, SCT_E_CANCELLED, -1, "cancelled in phase solve");
  return code == 0 ? SCT_OK : krylov_failed(k, code, "iteration", err);
}

/* Runs until the true residual is small enough, or no run halves it. *x is the best so far. */
static sct_status iterate_to_target(krylov *k, const double *b, double *x, sct_error *err) {
  double residual = true_residual(k, b, x);
  for (int run = 0; run <= RESTARTS && residual > k->target && k->spent < k->limit; run++) {
    sct_status status = iterate(k, b, x, err);
    if (status != SCT_OK) return status;
    const double before = residual;
    residual = true_residual(k, b, x);
    if (!(residual <= 0.5 * before)) break;
  }
  k->report->relative_residual = k->scale > 0 ? residual / k->scale : residual;
  if (residual <= k->target) return SCT_OK;
  return sct_fail(err, SCT_E_CONVERGENCE, -1,
                  "%s with %s is at a residual of %.1e after %d iterations, needs %.1e",
                  k->report->krylov, k->report->preconditioner, k->report->relative_residual,
                  k->spent, k->target / k->scale);
}

static void begin_solve(krylov *k, const double *b, bool transposed, sct_solve_report *report) {
  const sct_solve_options *o = &k->options;
  k->transposed = transposed;
  k->report = report;
  k->scale = norm(k, b);
  k->target = (o->tolerance > 0 ? o->tolerance : TOLERANCE) * k->scale;
  k->limit = o->max_iterations > 0 && o->max_iterations < INT_MAX ? (int)o->max_iterations
             : o->max_iterations > 0                              ? INT_MAX
                                                                  : MAX_ITERATIONS;
  k->spent = 0;
  report->iterations = report->history_count = 0;
  report->history_every = 1;
}

/* GMRES does not break down, and what defeats one preconditioner may suit the other. */
static sct_status try_second(krylov *k, const double *b, double *x, sct_error *err) {
  k->is_second = true;
  k->preconditioner = k->preconditioner == SCT_ILU ? sct_solve_multigrid(&k->traits) : SCT_ILU;
  sct_status status = krylov_set_up(k, k->report, err);
  if (status != SCT_OK) return status;
  memset(x, 0, (size_t)k->rows * sizeof *x);
  return iterate_to_target(k, b, x, err);
}

sct_status krylov_solve(krylov *k, const double *b, bool transposed, double *x,
                        sct_solve_report *report, sct_error *err) {
  begin_solve(k, b, transposed, report);
  if (!k->options.guess || !isfinite(norm(k, x)) || k->scale == 0) {
    memset(x, 0, (size_t)k->rows * sizeof *x);
  }
  petsc_own(&k->blocks);
  /* hypre's smoothers have no transposed */
  const bool suits = !transposed || k->preconditioner == SCT_ILU;
  sct_status status = suits ? iterate_to_target(k, b, x, err) : SCT_E_CONVERGENCE;
  const bool more = !k->is_second && k->spent < k->limit;
  if (status == SCT_E_CONVERGENCE && more) status = try_second(k, b, x, err);
  petsc_own(NULL);
  return status;
}
