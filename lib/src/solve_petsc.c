/* Krylov methods of PETSc's, with a preconditioner, for what is too large to factor. */
#include <pthread.h>
#include <string.h>

#include "alloc.h"
#include "petsc_krylov.h"
#include "solve_kind.h"

typedef struct {
  krylov by;
  const sct_solve_matrix *a;
  double *r; /* [n] the residual, the same room at every solve */
} petsc_state;

static void release(void *state) {
  petsc_state *s = state;
  krylov_drop(&s->by);
  petsc_keep(&s->by.blocks);
  sct_release(&s->r);
  sct_release(&s);
}

/* r = b - A x, or b - A^T x; returns |r|^2. */
static double residual(void *of, bool transposed, const double *b, const double *x) {
  const petsc_state *s = of;
  const sct_solve_matrix *a = s->a;
  double *const r = s->r, sum = 0;
  memcpy(r, b, (size_t)a->n * sizeof *r);
  for (int i = 0; i < a->n; i++) {
    for (int k = a->start[i]; k < a->start[i + 1]; k++) {
      const int j = a->index[k];
      if (transposed)
        r[j] -= a->value[k] * x[i];
      else
        r[i] -= a->value[k] * x[j];
    }
  }
  for (int i = 0; i < a->n; i++) sum += r[i] * r[i];
  return sum;
}

static void begin(petsc_state *s, const sct_solve_options *options) {
  *s = (petsc_state){.a = NULL};
  s->by = (krylov){.petsc = petsc_open(NULL), /* load succeeded */
                   .options = *options,
                   .residual = residual,
                   .of = s};
}

static sct_status analyse(const sct_solve_matrix *a, const sct_solve_options *options, void **state,
                          sct_solve_report *report, sct_error *err) {
  (void)report;
  petsc_state *s = NULL;
  sct_status status = sct_alloc_zero(&s, 1, sizeof *s, err);
  *state = s;
  if (status != SCT_OK) return status;
  begin(s, options);
  return sct_alloc(&s->r, a->n, sizeof *s->r, err);
}

static PetscErrorCode make_objects(petsc_state *s, const sct_solve_matrix *a) {
  krylov *k = &s->by;
  const petsc_calls *p = k->petsc;
  s->a = a;
  k->rows = a->n;
  k->nonzeros = a->start[a->n];
  PetscErrorCode code = p->MatCreateSeqAIJWithArrays(
      p->self, a->n, a->n, a->start, (int *)(uintptr_t)a->index, a->value, &k->matrix);
  if (code == 0) code = p->VecCreateSeqWithArray(p->self, 1, a->n, NULL, &k->rhs);
  if (code == 0) code = p->VecCreateSeqWithArray(p->self, 1, a->n, NULL, &k->x);
  return code;
}

static sct_status factor(void *state, const sct_solve_matrix *a, sct_solve_report *report,
                         sct_error *err) {
  petsc_state *s = state;
  krylov *k = &s->by;
  krylov_drop(k);
  k->is_second = false;
  k->traits = sct_solve_traits_of(a->source, k->options.dim);
  k->preconditioner = krylov_first(k);
  petsc_own(&k->blocks);
  const PetscErrorCode code = make_objects(s, a);
  const sct_status status =
      code == 0 ? krylov_set_up(k, report, err) : krylov_failed(k, code, "matrix", err);
  petsc_own(NULL);
  return status;
}

static sct_status solve(void *state, const sct_solve_matrix *a, const double *b, bool transposed,
                        double *x, sct_solve_report *report, sct_error *err) {
  petsc_state *s = state;
  s->a = a;
  return krylov_solve(&s->by, b, transposed, x, report, err);
}

/* ---- loading ---- */

/* What PETSc registers at the first use of anything stays for good: so everything is used once. */
static sct_status use(sct_preconditioner preconditioner, bool is_second) {
  int64_t starts[] = {0, 2, 5, 7};
  int start[] = {0, 2, 5, 7};
  int32_t column[] = {0, 1, 0, 1, 2, 1, 2};
  double value[] = {1, -0.4, -0.4, 1, -0.4, -0.4, 1}, x[3] = {0}, r[3];
  const double b[] = {1, 2, 3};
  const sct_csr source = {3, 3, starts, column, value};
  const sct_solve_matrix a = {
      .n = 3, .by_rows = true, .start = start, .index = column, .value = value, .source = &source};
  const sct_solve_options options = {.dim = 2};
  petsc_state s;
  sct_solve_report report = {0};
  begin(&s, &options);
  s.by.preconditioner = preconditioner;
  s.by.is_second = is_second;
  s.r = r;
  petsc_own(&s.by.blocks);
  sct_status status =
      make_objects(&s, &a) == 0 ? krylov_set_up(&s.by, &report, NULL) : SCT_E_MEMORY;
  if (status == SCT_OK) status = krylov_solve(&s.by, b, false, x, &report, NULL);
  krylov_drop(&s.by);
  petsc_keep(&s.by.blocks);
  return status;
}

static sct_error unusable; /* code SCT_OK: it is usable */

static void use_all(void) {
  if (petsc_open(&unusable) == NULL) return;
  for (int k = SCT_ILU; k <= SCT_AMG_AGGRESSIVE; k++) {
    const sct_status status = use((sct_preconditioner)k, k == SCT_ILU);
    if (status == SCT_OK && (k != SCT_ILU || use(SCT_ILU, false) == SCT_OK)) continue;
    (void)sct_fail(&unusable, status == SCT_OK ? SCT_E_MEMORY : status, -1,
                   "PETSc does not start: %s of three rows fails", k == SCT_ILU ? "ilu" : "amg");
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
