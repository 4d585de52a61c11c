/* The front of the table of solvers: checks, refines, estimates, falls back; the packages only
 * factor and substitute, or iterate, with D A instead of A (solve_matrix.h). */
#include "scatter/solve.h"

#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "alloc.h"
#include "seconds.h"
#include "solve_kind.h"
#include "solve_policy.h"

struct sct_solver {
  const sct_solve_kind *kind;
  void *state;             /* of kind */
  sct_solve_matrix scaled; /* D A */
  sct_solve_options options;
  double *work;     /* [4][n] scaled right-hand side, residual, its scale, second iterate */
  const sct_csr *a; /* the factored matrix, borrowed; NULL: none */
  sct_solve_report report;
};

/* Below, the matrix is taken for singular: not two digits of the solution would be sure. Operators
 * with fluxes all around (every scheme, 1-D to 3-D, 11 to 1e5 points) come out at 1e-20 to 1.5e-15
 * by rounding, sound ones above 1e-8. */
static const double least_reciprocal_condition = 1e-14;

static const sct_solve_kind *const kinds[] = {&sct_solve_umfpack, &sct_solve_klu, &sct_solve_petsc};
enum { KINDS = sizeof kinds / sizeof *kinds };

void sct_solver_prepare(void) {
  for (int k = 0; k < KINDS; k++) {
    if (kinds[k]->prepare != NULL) kinds[k]->prepare();
  }
}

sct_status sct_solver_load_iterative(sct_error *err) {
  return sct_solve_petsc.load(err);
}

const char *sct_solver_name(int k) {
  return k >= 0 && k < KINDS ? kinds[k]->name : NULL;
}

static const sct_solve_kind *direct_kind(int64_t rows, int dim) {
  return sct_solve_suits_klu(rows, dim) ? &sct_solve_klu : &sct_solve_umfpack;
}

static const sct_solve_kind *automatic_kind(const sct_csr *a, int dim) {
  const sct_solve_traits traits = sct_solve_traits_of(a, dim);
  if (sct_solve_suits_iteration(&traits) && sct_solver_load_iterative(NULL) == SCT_OK) {
    return &sct_solve_petsc;
  }
  return direct_kind(a->rows, dim);
}

bool sct_solver_iterates(const sct_solve_options *options, int64_t rows) {
  const char *method = options == NULL || options->method == NULL ? "auto" : options->method;
  const bool is_auto = strcmp(method, "auto") == 0;
  if (!is_auto && strcmp(method, sct_solve_petsc.name) != 0) return false;
  const int dim = options == NULL ? 0 : options->dim;
  const sct_solve_traits least = {.dim = dim, .rows = rows, .dominance = 1, .skewness = 1};
  if (is_auto && !sct_solve_suits_iteration(&least)) return false;
  return sct_solver_load_iterative(NULL) == SCT_OK;
}

static sct_status choose(const sct_csr *a, const sct_solve_options *options,
                         const sct_solve_kind **kind, sct_error *err) {
  const char *method = options->method == NULL ? "auto" : options->method;
  if (strcmp(method, "auto") == 0) {
    *kind = automatic_kind(a, options->dim);
    return SCT_OK;
  }
  *kind = direct_kind(a->rows, options->dim);
  if (strcmp(method, "direct") == 0) return SCT_OK;
  char known[128] = "auto, direct";
  size_t length = strlen(known);
  for (int k = 0; k < KINDS; k++) {
    if (strcmp(method, kinds[k]->name) == 0) {
      *kind = kinds[k];
      return kinds[k]->load == NULL ? SCT_OK : kinds[k]->load(err);
    }
    length += (size_t)snprintf(known + length, sizeof known - length, ", %s", kinds[k]->name);
  }
  return sct_fail(err, SCT_E_ARGUMENT, -1, "solver is \"%.40s\", known are %s", method, known);
}

static sct_status check_size(const sct_csr *a, sct_error *err) {
  if (a->rows != a->columns || a->rows < 1) {
    return sct_fail(err, SCT_E_ARGUMENT, -1,
                    "matrix is %lld x %lld, needs as many rows as columns, at least one",
                    (long long)a->rows, (long long)a->columns);
  }
  if (a->rows >= INT_MAX || sct_csr_entries(a) > INT_MAX) {
    return sct_fail(err, SCT_E_LIMIT, -1, "matrix has %lld rows and %lld entries, limit is %d",
                    (long long)a->rows, (long long)sct_csr_entries(a), INT_MAX);
  }
  return SCT_OK;
}

static bool row_is_sorted(const sct_csr *a, int64_t i) {
  int64_t last = -1;
  for (int64_t k = a->start[i]; k < a->start[i + 1]; k++) {
    if (a->column[k] <= last || a->column[k] >= a->columns) return false;
    last = a->column[k];
  }
  return a->start[i + 1] >= a->start[i];
}

static sct_status check_pattern(const sct_csr *a, sct_error *err) {
  for (int64_t i = 0; i < a->rows; i++) {
    if (row_is_sorted(a, i)) continue;
    return sct_fail(err, SCT_E_ARGUMENT, -1, "columns of row %lld are not ascending below %lld",
                    (long long)i, (long long)a->columns);
  }
  return SCT_OK;
}

/* Takes the pattern into the package of `kind`, in the place of whatever there was. */
static sct_status begin_kind(sct_solver *s, const sct_solve_kind *kind, const sct_csr *a,
                             sct_error *err) {
  if (s->state != NULL) s->kind->free(s->state);
  s->state = NULL;
  sct_solve_matrix_clear(&s->scaled);
  s->kind = kind;
  s->report.method = kind->name;
  s->report.ordering = NULL;
  sct_status status = sct_solve_matrix_pattern(&s->scaled, a, kind->iterates, err);
  if (status != SCT_OK) return status;
  return kind->analyse(&s->scaled, &s->options, &s->state, &s->report, err);
}

sct_status sct_solver_analyse(const sct_csr *a, const sct_solve_options *options,
                              sct_solver **solver, sct_error *err) {
  static const sct_solve_options defaults = {.method = "auto"};
  if (options == NULL) options = &defaults;
  const double begin = seconds_now();
  sct_solver *s = NULL;
  const sct_solve_kind *kind;
  sct_status status = check_size(a, err);
  if (status != SCT_OK) goto done;
  status = check_pattern(a, err);
  if (status != SCT_OK) goto done;
  status = choose(a, options, &kind, err);
  if (status != SCT_OK) goto done;
  status = sct_alloc_zero(&s, 1, sizeof *s, err);
  if (status != SCT_OK) goto done;
  status = sct_alloc(&s->work, 4 * a->rows, sizeof *s->work, err);
  if (status != SCT_OK) goto done;
  s->options = *options;
  s->report.rows = a->rows;
  s->report.nonzeros = sct_csr_entries(a);
  status = begin_kind(s, kind, a, err);
  s->report.seconds_factor = seconds_now() - begin;
done:
  if (status != SCT_OK) sct_solver_free(&s);
  *solver = s;
  return status;
}

void sct_solver_free(sct_solver **solver) {
  sct_solver *s = *solver;
  if (s == NULL) return;
  if (s->state != NULL) s->kind->free(s->state);
  sct_solve_matrix_clear(&s->scaled);
  sct_release(&s->work);
  sct_release(solver);
}

const sct_solve_report *sct_solver_report(const sct_solver *solver) {
  return &solver->report;
}

static double max_abs(const double *x, int n, int *at) {
  double largest = 0;
  for (int i = 0; i < n; i++) {
    if (!(fabs(x[i]) <= largest)) {
      largest = fabs(x[i]);
      *at = i;
    }
  }
  return largest;
}

/* 1 / || |A^-1| |A| e ||, Skeel's condition number, which no scaling of rows changes: with
 * w = |DA| e it is the largest row sum of C = (DA)^-1 diag(w). Two steps of Hager's method:
 * z = C e is exact where A^-1 >= 0 (an M-matrix), a lower bound else; then the row sum of the row j
 * where |z| is largest. A method of two substitutions, so that every factorisation can afford it
 * (the pivots' ratio, which the packages offer, is off by factors of h^-2). */
static sct_status reciprocal_condition(sct_solver *s, double *rcond, sct_error *err) {
  const sct_solve_matrix *m = &s->scaled;
  double *w = s->work, *z = w + m->n, *e = z + m->n, *y = e + m->n;
  memset(w, 0, (size_t)m->n * sizeof *w);
  for (int p = 0; p < m->start[m->n]; p++) w[m->index[p]] += fabs(m->value[p]);
  sct_status status = s->kind->solve(s->state, m, w, false, z, &s->report, err);
  if (status != SCT_OK) return status;
  int j = 0;
  const double first = max_abs(z, m->n, &j);
  memset(e, 0, (size_t)m->n * sizeof *e);
  e[j] = 1;
  status = s->kind->solve(s->state, m, e, true, y, &s->report, err);
  double second = 0;
  for (int i = 0; i < m->n; i++) second += w[i] * fabs(y[i]);
  *rcond = isfinite(first) && isfinite(second) ? 1 / fmax(first, second) : 0;
  return status;
}

/* Refuses what is singular to working precision; iterative rows do not know. */
static sct_status check_condition(sct_solver *s, sct_error *err) {
  double *rcond = &s->report.reciprocal_condition;
  *rcond = 0;
  if (s->kind->iterates) return SCT_OK;
  sct_status status = reciprocal_condition(s, rcond, err);
  if (status != SCT_OK || *rcond >= least_reciprocal_condition) return status;
  return sct_fail(err, SCT_E_SINGULAR, -1, "reciprocal condition number is %.1e, needs %.0e",
                  *rcond, least_reciprocal_condition);
}

static sct_status factor_values(sct_solver *s, const sct_csr *a, sct_error *err) {
  const uint8_t *is_equation = s->options.is_equation;
  sct_status status = SCT_OK;
  if (s->state == NULL) status = begin_kind(s, s->kind, a, err); /* it had no memory before */
  if (status == SCT_OK) status = sct_solve_matrix_values(&s->scaled, a, is_equation, err);
  if (status == SCT_OK) status = s->kind->factor(s->state, &s->scaled, &s->report, err);
  if (status == SCT_OK) status = check_condition(s, err);
  return status;
}

/* A direct solver in the place of one that does not converge, for good; `why` says what happened.
 * It is the failure where the direct one would be too slow. */
static sct_status fall_back(sct_solver *s, const sct_csr *a, const sct_error *why, sct_error *err) {
  if (!sct_solve_suits_fallback(a->rows, s->options.dim)) {
    if (err != NULL) *err = *why;
    return why->code;
  }
  snprintf(s->report.fallback, sizeof s->report.fallback, "%.*s", SCT_SOLVE_REASON - 1, why->text);
  sct_status status = begin_kind(s, direct_kind(a->rows, s->options.dim), a, err);
  return status == SCT_OK ? factor_values(s, a, err) : status;
}

sct_status sct_solver_factor(sct_solver *solver, const sct_csr *a, sct_error *err) {
  const double begin = seconds_now();
  const double analysis = solver->a == NULL ? solver->report.seconds_factor : 0;
  sct_error why = {.code = SCT_OK};
  solver->a = NULL;
  sct_status status = factor_values(solver, a, &why);
  if (status == SCT_E_CONVERGENCE) {
    status = fall_back(solver, a, &why, err);
  } else if (status != SCT_OK && err != NULL) {
    *err = why;
  }
  if (status != SCT_OK) return status;
  solver->a = a;
  solver->report.seconds_factor = analysis + seconds_now() - begin;
  return SCT_OK;
}

/* x = A^-1 b = (DA)^-1 D b, or A^-T b = D (DA)^-T b. */
static sct_status substitute(sct_solver *s, const double *b, bool transposed, double *x,
                             sct_error *err) {
  const int n = s->scaled.n;
  double *rhs = s->work;
  if (transposed) {
    sct_status status = s->kind->solve(s->state, &s->scaled, b, true, x, &s->report, err);
    for (int i = 0; status == SCT_OK && i < n; i++) x[i] *= s->scaled.scale[i];
    return status;
  }
  for (int i = 0; i < n; i++) rhs[i] = s->scaled.scale[i] * b[i];
  return s->kind->solve(s->state, &s->scaled, rhs, false, x, &s->report, err);
}

static bool all_finite(const double *x, int n) {
  for (int i = 0; i < n; i++) {
    if (!isfinite(x[i])) return false;
  }
  return true;
}

/* Residual r and max |r| / scale, infinity if x is not finite. */
static double backward_error(sct_solver *s, const double *x, const double *b, bool transposed) {
  const int n = s->scaled.n;
  double *r = s->work + n, *scale = r + n, worst = 0;
  if (!all_finite(x, n)) return INFINITY;
  (transposed ? sct_csr_residual_transposed : sct_csr_residual)(s->a, x, b, r, scale);
  for (int i = 0; i < n; i++) {
    if (r[i] != 0) worst = fmax(worst, fabs(r[i]) / scale[i]);
  }
  return worst;
}

/* One step x + A^-1 r, kept where it lowers the backward error. */
static sct_status refine(sct_solver *s, const double *b, bool transposed, double *x,
                         sct_error *err) {
  const int n = s->scaled.n;
  double *r = s->work + n, *second = r + 2 * (int64_t)n;
  sct_status status = substitute(s, r, transposed, second, err);
  if (status != SCT_OK) return status;
  for (int i = 0; i < n; i++) second[i] += x[i];
  const double error = backward_error(s, second, b, transposed);
  s->report.iterations = 1;
  if (error < s->report.residual) {
    s->report.residual = error;
    memcpy(x, second, (size_t)n * sizeof *x);
  }
  return SCT_OK;
}

/* By whoever is able to: the chosen solver, or the one that takes over. */
static sct_status substitute_or_fall_back(sct_solver *s, const double *b, bool transposed,
                                          double *x, sct_error *err) {
  sct_error why = {.code = SCT_OK};
  const sct_csr *a = s->a;
  sct_status status = substitute(s, b, transposed, x, &why);
  if (status != SCT_E_CONVERGENCE) {
    if (status != SCT_OK && err != NULL) *err = why;
    if (status != SCT_OK) s->a = NULL; /* the preconditioner went with the memory */
    return status;
  }
  s->a = NULL; /* until there are factors again */
  status = fall_back(s, a, &why, err);
  if (status != SCT_OK) return status;
  s->a = a;
  return substitute(s, b, transposed, x, err);
}

sct_status sct_solver_solve(sct_solver *solver, const double *b, bool transposed, double *x,
                            sct_error *err) {
  const double begin = seconds_now();
  const int n = solver->scaled.n;
  sct_solve_report *report = &solver->report;
  if (solver->a == NULL) return sct_fail(err, SCT_E_ARGUMENT, -1, "nothing is factored");
  if (!all_finite(b, n)) {
    return sct_fail(err, SCT_E_NOT_FINITE, -1, "the right-hand side is not finite");
  }
  sct_status status = substitute_or_fall_back(solver, b, transposed, x, err);
  if (status != SCT_OK) return status;
  const bool direct = !solver->kind->iterates;
  if (direct) report->iterations = 0;
  report->residual = backward_error(solver, x, b, transposed);
  const double content = fmax(solver->options.backward_error, DBL_EPSILON);
  if (direct && report->residual > content && isfinite(report->residual)) {
    status = refine(solver, b, transposed, x, err);
  }
  if (status != SCT_OK) return status;
  if (!isfinite(report->residual)) {
    return sct_fail(err, SCT_E_SINGULAR, -1,
                    "the solution is not finite, reciprocal condition %.1e",
                    report->reciprocal_condition);
  }
  report->seconds_solve = seconds_now() - begin;
  return SCT_OK;
}
