/* The only door to PETSc, and to hypre behind it: Krylov methods with a preconditioner, for what is
 * too large to factor.
 *
 * A solve is a series of attempts. BiCGStab goes first, right-preconditioned, so that the residual
 * it sees is that of D A; the one it computes recursively drifts from the true one, so where it
 * ends the true one is looked at, and if that is too large BiCGStab starts again from there. Where
 * that stagnates GMRES tries with the other preconditioner; after that the front falls back. */
#include <limits.h>
#include <math.h>
#include <pthread.h>
#include <string.h>

#include "alloc.h"
#include "petsc_calls.h"
#include "solve_kind.h"
#include "solve_policy.h"

enum { MAX_ITERATIONS = 1000, RESTARTS = 4, PATIENCE = 200 };
static const double TOLERANCE = 1e-10;

typedef struct {
  const petsc_calls *petsc;
  sct_solve_options options;
  sct_solve_traits traits;
  sct_preconditioner preconditioner;
  bool is_second; /* GMRES, with the other preconditioner */
  Mat matrix;
  Vec rhs, x;
  KSP ksp;
  petsc_block *blocks; /* their memory */
  /* of the solve under way */
  sct_solve_report *report;
  double target, scale; /* norms of residual to reach, of the right-hand side */
  double best, best_at; /* least norm so far, and when it was last halved */
  int spent, limit;     /* iterations */
} petsc_state;

/* Gives up all objects, finished or not. */
static void abandon(petsc_state *s) {
  petsc_abandon(&s->blocks);
  s->ksp = NULL;
  s->matrix = NULL;
  s->rhs = s->x = NULL;
}

/* An error of PETSc's; one of memory leaves ruins. */
static sct_status failed(petsc_state *s, PetscErrorCode code, const char *what, sct_error *err) {
  if (code == PETSC_ERR_MEM || petsc_ran_out()) {
    abandon(s);
    return sct_fail(err, SCT_E_MEMORY, -1, "no memory in %s of petsc", what);
  }
  return sct_fail(err, SCT_E_CONVERGENCE, -1, "%s of petsc: error %d, %s", what, (int)code,
                  petsc_complaint());
}

/* Destroys the Krylov method; it may need memory for that, which PETSc then keeps. */
static sct_status drop_ksp(petsc_state *s, sct_error *err) {
  petsc_own(NULL);
  const PetscErrorCode code = s->ksp == NULL ? 0 : s->petsc->KSPDestroy(&s->ksp);
  if (code == 0) return SCT_OK;
  abandon(s);
  return sct_fail(err, SCT_E_MEMORY, -1, "no memory to free a solver of petsc: error %d",
                  (int)code);
}

static void drop(petsc_state *s) {
  if (drop_ksp(s, NULL) != SCT_OK) return;
  PetscErrorCode code = 0;
  if (s->matrix != NULL) code = s->petsc->MatDestroy(&s->matrix);
  if (code == 0 && s->rhs != NULL) code = s->petsc->VecDestroy(&s->rhs);
  if (code == 0 && s->x != NULL) code = s->petsc->VecDestroy(&s->x);
  if (code != 0) abandon(s);
}

static void release(void *state) {
  petsc_state *s = state;
  drop(s);
  petsc_keep(&s->blocks);
  sct_release(&s);
}

static sct_status analyse(const sct_solve_matrix *a, const sct_solve_options *options, void **state,
                          sct_solve_report *report, sct_error *err) {
  (void)a;
  (void)report;
  petsc_state *s = NULL;
  sct_status status = sct_alloc_zero(&s, 1, sizeof *s, err);
  *state = s;
  if (status != SCT_OK) return status;
  s->options = *options;
  s->petsc = petsc_open(NULL); /* load succeeded */
  return SCT_OK;
}

/* ---- the preconditioner ---- */

/* Called at the start of a solve and after each iteration: keeps the history, and ends the attempt
 * where the target is met, or where in PATIENCE iterations, or as many as there were before, the
 * norm was not halved. */
static PetscErrorCode watch(KSP ksp, PetscInt iteration, PetscReal norm, KSPConvergedReason *reason,
                            void *context) {
  petsc_state *s = context;
  const double at = s->spent + (double)iteration;
  (void)ksp;
  *reason = KSP_CONVERGED_ITERATING;
  sct_solve_report *r = s->report;
  if (r->history_count == SCT_SOLVE_HISTORY) { /* every other one goes */
    r->history_count /= 2;
    r->history_every *= 2;
    for (int64_t k = 0; k < r->history_count; k++) r->history[k] = r->history[2 * k];
  }
  if (at == (double)r->history_count * r->history_every) {
    r->history[r->history_count++] = norm / s->scale;
  }
  if (norm <= 0.5 * s->best) {
    s->best = norm;
    s->best_at = at;
  }
  if (norm <= s->target)
    *reason = KSP_CONVERGED_RTOL;
  else if (!(norm <= 1e6 * s->scale))
    *reason = KSP_DIVERGED_DTOL;
  else if (at >= s->limit || at - s->best_at > fmax(PATIENCE, 0.5 * at))
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

static PetscErrorCode make_ksp(petsc_state *s) {
  const petsc_calls *p = s->petsc;
  const char *prefix = preconditioners[s->preconditioner].prefix;
  PC pc;
  PetscErrorCode code = p->KSPCreate(p->self, &s->ksp);
  if (code == 0) code = p->KSPSetOperators(s->ksp, s->matrix, s->matrix);
  if (code == 0) code = p->KSPSetType(s->ksp, s->is_second ? KSPGMRES : KSPBCGS);
  if (code == 0) code = p->KSPSetPCSide(s->ksp, PC_RIGHT);
  if (code == 0) code = p->KSPSetNormType(s->ksp, KSP_NORM_UNPRECONDITIONED);
  if (code == 0) code = p->KSPSetConvergenceTest(s->ksp, watch, s, NULL);
  if (code == 0) code = p->KSPGetPC(s->ksp, &pc);
  if (code == 0 && prefix == NULL) code = p->PCSetType(pc, PCILU);
  if (code == 0 && prefix != NULL) code = p->KSPSetOptionsPrefix(s->ksp, prefix);
  if (code == 0 && prefix != NULL) code = p->KSPSetFromOptions(s->ksp);
  return code;
}

/* hypre does not survive where there is no memory, so that is looked for first: two and a half
 * times its entries is what it took at most, rows of 13 to 110 entries. */
static bool has_room_for_multigrid(const sct_solve_matrix *a) {
  const int64_t bytes = (int64_t)a->start[a->n] * (int64_t)(sizeof(double) + sizeof(int));
  void *room = NULL;
  const bool found = sct_alloc(&room, 5 * bytes / 2 + (16 << 20), 1, NULL) == SCT_OK;
  sct_release(&room);
  return found;
}

static PetscErrorCode make_objects(petsc_state *s, const sct_solve_matrix *a) {
  const petsc_calls *p = s->petsc;
  PetscErrorCode code = p->MatCreateSeqAIJWithArrays(
      p->self, a->n, a->n, a->start, (int *)(uintptr_t)a->index, a->value, &s->matrix);
  if (code == 0) code = p->VecCreateSeqWithArray(p->self, 1, a->n, NULL, &s->rhs);
  if (code == 0) code = p->VecCreateSeqWithArray(p->self, 1, a->n, NULL, &s->x);
  return code;
}

/* Krylov method and preconditioner, in the place of those before. */
static sct_status set_up(petsc_state *s, const sct_solve_matrix *a, sct_solve_report *report,
                         sct_error *err) {
  PCFailedReason reason = PC_NOERROR;
  PC pc;
  sct_status status = drop_ksp(s, err);
  if (status != SCT_OK) return status;
  petsc_own(&s->blocks);
  if (s->preconditioner != SCT_ILU && !has_room_for_multigrid(a)) s->preconditioner = SCT_ILU;
  PetscErrorCode code = make_ksp(s);
  if (code == 0) code = s->petsc->KSPSetUp(s->ksp);
  if (code == 0) code = s->petsc->KSPGetPC(s->ksp, &pc);
  if (code == 0) code = s->petsc->PCGetFailedReason(pc, &reason);
  if (code != 0) return failed(s, code, "preconditioner", err);
  report->krylov = s->is_second ? "gmres" : "bicgstab";
  report->preconditioner = preconditioners[s->preconditioner].name;
  report->factor_nonzeros = s->preconditioner == SCT_ILU ? a->start[a->n] : 0;
  report->peak_bytes = report->factor_nonzeros * (int64_t)(sizeof(double) + sizeof(int));
  if (reason == PC_NOERROR) return SCT_OK;
  return sct_fail(err, SCT_E_CONVERGENCE, -1, "the preconditioner %s cannot be made",
                  report->preconditioner);
}

static sct_preconditioner chosen(const petsc_state *s) {
  const char *wanted = s->options.preconditioner;
  if (wanted == NULL) return sct_solve_preconditioner(&s->traits);
  return strcmp(wanted, "ilu") == 0 ? SCT_ILU : sct_solve_multigrid(&s->traits);
}

static sct_status factor(void *state, const sct_solve_matrix *a, sct_solve_report *report,
                         sct_error *err) {
  petsc_state *s = state;
  drop(s);
  s->is_second = false;
  s->traits = sct_solve_traits_of(a->source, s->options.dim);
  s->preconditioner = chosen(s);
  petsc_own(&s->blocks);
  const PetscErrorCode code = make_objects(s, a);
  const sct_status status = code == 0 ? set_up(s, a, report, err) : failed(s, code, "matrix", err);
  petsc_own(NULL);
  return status;
}

/* ---- a solve ---- */

static double norm(const double *x, int n) {
  double sum = 0;
  for (int i = 0; i < n; i++) sum += x[i] * x[i];
  return sqrt(sum);
}

static double true_residual(const sct_solve_matrix *a, const double *b, const double *x) {
  double sum = 0;
  for (int i = 0; i < a->n; i++) {
    double r = b[i];
    for (int k = a->start[i]; k < a->start[i + 1]; k++) r -= a->value[k] * x[a->index[k]];
    sum += r * r;
  }
  return sqrt(sum);
}

/* One run of the Krylov method from x. */
static sct_status iterate(petsc_state *s, const double *b, double *x, sct_error *err) {
  const petsc_calls *p = s->petsc;
  PetscInt count = 0;
  s->best = INFINITY;
  s->best_at = s->spent;
  PetscErrorCode code = p->VecPlaceArray(s->rhs, b);
  if (code == 0) code = p->VecPlaceArray(s->x, x);
  if (code == 0) code = p->KSPSetInitialGuessNonzero(s->ksp, PETSC_TRUE);
  if (code == 0) code = p->KSPSolve(s->ksp, s->rhs, s->x);
  (void)p->VecResetArray(s->rhs);
  (void)p->VecResetArray(s->x);
  if (code == 0) code = p->KSPGetIterationNumber(s->ksp, &count);
  s->spent += (int)count;
  s->report->iterations = s->spent;
  return code == 0 ? SCT_OK : failed(s, code, "iteration", err);
}

/* Runs until the true residual is small enough, or no run halves it. *x is the best so far. */
static sct_status iterate_to_target(petsc_state *s, const sct_solve_matrix *a, const double *b,
                                    double *x, sct_error *err) {
  double residual = true_residual(a, b, x);
  for (int run = 0; run <= RESTARTS && residual > s->target && s->spent < s->limit; run++) {
    sct_status status = iterate(s, b, x, err);
    if (status != SCT_OK) return status;
    const double before = residual;
    residual = true_residual(a, b, x);
    if (!(residual <= 0.5 * before)) break;
  }
  s->report->relative_residual = s->scale > 0 ? residual / s->scale : residual;
  if (residual <= s->target) return SCT_OK;
  return sct_fail(err, SCT_E_CONVERGENCE, -1,
                  "%s with %s is at a residual of %.1e after %d iterations, needs %.1e",
                  s->report->krylov, s->report->preconditioner, s->report->relative_residual,
                  s->spent, s->target / s->scale);
}

static void begin_solve(petsc_state *s, const double *b, int n, sct_solve_report *report) {
  const sct_solve_options *o = &s->options;
  s->report = report;
  s->scale = norm(b, n);
  s->target = (o->tolerance > 0 ? o->tolerance : TOLERANCE) * s->scale;
  s->limit = o->max_iterations > 0 && o->max_iterations < INT_MAX ? (int)o->max_iterations
             : o->max_iterations > 0                              ? INT_MAX
                                                                  : MAX_ITERATIONS;
  s->spent = 0;
  report->iterations = report->history_count = 0;
  report->history_every = 1;
}

/* GMRES does not break down, and what defeats one preconditioner may suit the other. */
static sct_status try_second(petsc_state *s, const sct_solve_matrix *a, const double *b, double *x,
                             sct_error *err) {
  s->is_second = true;
  s->preconditioner = s->preconditioner == SCT_ILU ? sct_solve_multigrid(&s->traits) : SCT_ILU;
  sct_status status = set_up(s, a, s->report, err);
  if (status != SCT_OK) return status;
  memset(x, 0, (size_t)a->n * sizeof *x);
  return iterate_to_target(s, a, b, x, err);
}

static sct_status solve(void *state, const sct_solve_matrix *a, const double *b, bool transposed,
                        double *x, sct_solve_report *report, sct_error *err) {
  petsc_state *s = state;
  if (transposed) return sct_fail(err, SCT_E_CONVERGENCE, -1, "a transposed solve is not iterated");
  begin_solve(s, b, a->n, report);
  if (!s->options.guess || !isfinite(norm(x, a->n))) memset(x, 0, (size_t)a->n * sizeof *x);
  if (s->scale == 0) memset(x, 0, (size_t)a->n * sizeof *x);
  petsc_own(&s->blocks);
  sct_status status = iterate_to_target(s, a, b, x, err);
  const bool more = !s->is_second && s->spent < s->limit;
  if (status == SCT_E_CONVERGENCE && more) status = try_second(s, a, b, x, err);
  petsc_own(NULL);
  return status;
}

/* ---- loading ---- */

/* What PETSc registers at the first use of anything stays for good: so everything is used once. */
static sct_status use(sct_preconditioner preconditioner, bool is_second) {
  int64_t starts[] = {0, 2, 5, 7};
  int start[] = {0, 2, 5, 7};
  int32_t column[] = {0, 1, 0, 1, 2, 1, 2};
  double value[] = {1, -0.4, -0.4, 1, -0.4, -0.4, 1}, x[3] = {0};
  const double b[] = {1, 2, 3};
  const sct_csr source = {3, 3, starts, column, value};
  const sct_solve_matrix a = {
      .n = 3, .by_rows = true, .start = start, .index = column, .value = value, .source = &source};
  petsc_state s = {.petsc = petsc_open(NULL),
                   .preconditioner = preconditioner,
                   .is_second = is_second,
                   .options.dim = 2};
  sct_solve_report report = {0};
  begin_solve(&s, b, 3, &report);
  sct_status status = make_objects(&s, &a) == 0 ? set_up(&s, &a, &report, NULL) : SCT_E_MEMORY;
  if (status == SCT_OK) status = iterate_to_target(&s, &a, b, x, NULL);
  drop(&s);
  petsc_keep(&s.blocks);
  return status;
}

static sct_error unusable; /* code SCT_OK: it is usable */

static void use_all(void) {
  if (petsc_open(&unusable) == NULL) return;
  for (int k = SCT_ILU; k <= SCT_AMG_AGGRESSIVE; k++) {
    const sct_status status = use((sct_preconditioner)k, k == SCT_ILU);
    if (status == SCT_OK && (k != SCT_ILU || use(SCT_ILU, false) == SCT_OK)) continue;
    (void)sct_fail(&unusable, status == SCT_OK ? SCT_E_MEMORY : status, -1,
                   "PETSc does not start: %s of three rows fails", preconditioners[k].name);
    return;
  }
}

static sct_status load(sct_error *err) {
  static pthread_once_t once = PTHREAD_ONCE_INIT;
  pthread_once(&once, use_all);
  if (unusable.code != SCT_OK && err != NULL) *err = unusable;
  return unusable.code;
}

static void prepare(void) {
  (void)load(NULL);
}

const sct_solve_kind sct_solve_petsc = {.name = "iterative",
                                        .iterates = true,
                                        .prepare = prepare,
                                        .load = load,
                                        .analyse = analyse,
                                        .factor = factor,
                                        .solve = solve,
                                        .free = release};
