#include "limited_iterate.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "alloc.h"
#include "anderson.h"
#include "limited_rows.h"

/* Changes below this part of phi are rounding. */
static const double ROUNDING = 1e-13;

/* Anderson's steps seek the least change, which need not be zero: where the limiter folds q, the
 * least change can lie off the solution and the iteration stays there. Plain steps drift past. */
enum {
  PATIENCE = 8, /* accelerated steps without a new least change before plain ones begin */
  DRIFT = 4     /* plain steps at least */
};
static const double PROGRESS = 0.9; /* of the least change so far: a new one */
static const double PASSED = 0.3;   /* of the largest change of plain steps: the fold is passed */

/* Which steps are taken. */
typedef struct {
  bool is_plain;
  int idle;     /* accelerated steps since the least change, or plain steps */
  double least; /* change of accelerated steps */
  double most;  /* change of plain steps */
} pace;

struct sct_limited_iteration {
  double *phi;       /* [n] */
  double *gradient;  /* [n][dim] */
  double *q, *r, *f; /* [unknowns] */
  double *best;      /* [unknowns] y + f of the least change */
  sct_anderson *anderson;
};

sct_status sct_limited_iteration_new(const sct_system *system, sct_limited_iteration **out,
                                     sct_error *err) {
  sct_limited_iteration *it = NULL;
  const int64_t m = system->unknowns;
  sct_status status = sct_alloc_zero(&it, 1, sizeof *it, err);
  if (status == SCT_OK) status = sct_alloc(&it->phi, system->n, sizeof *it->phi, err);
  if (status == SCT_OK) {
    status = sct_alloc(&it->gradient, system->n * system->limited->dim, sizeof(double), err);
  }
  if (status == SCT_OK) status = sct_alloc(&it->q, m, sizeof *it->q, err);
  if (status == SCT_OK) status = sct_alloc(&it->r, m, sizeof *it->r, err);
  if (status == SCT_OK) status = sct_alloc(&it->f, m, sizeof *it->f, err);
  if (status == SCT_OK) status = sct_alloc(&it->best, m, sizeof *it->best, err);
  if (status == SCT_OK) status = sct_anderson_new(m, &it->anderson, err);
  if (status != SCT_OK) sct_limited_iteration_free(&it);
  *out = it;
  return status;
}

void sct_limited_iteration_free(sct_limited_iteration **iteration) {
  sct_limited_iteration *it = *iteration;
  if (it == NULL) return;
  sct_anderson_free(&it->anderson);
  sct_release(&it->phi);
  sct_release(&it->gradient);
  sct_release(&it->q);
  sct_release(&it->r);
  sct_release(&it->f);
  sct_release(&it->best);
  sct_release(iteration);
}

const double *sct_limited_iteration_correction(sct_limited_iteration *it, const sct_system *system,
                                               const double *phi, const double *y,
                                               const sct_work *work) {
  memcpy(it->phi, phi, (size_t)system->n * sizeof *phi);
  for (int64_t row = 0; row < system->unknowns; row++) it->phi[system->point_of[row]] = y[row];
  sct_limited_correction(system, it->phi, work, it->gradient, it->q);
  return it->q;
}

static double largest(const double *value, int64_t n) {
  double size = 0;
  for (int64_t k = 0; k < n; k++) size = fmax(size, fabs(value[k]));
  return size;
}

/* r = rhs - own y - shift (A y - q)                                              header, (5) */
static void residual(sct_limited_iteration *it, const sct_limited_equation *e, const double *y) {
  const sct_system *system = e->system;
  sct_csr_multiply(system->matrix, y, it->r);
  for (int64_t row = 0; row < system->unknowns; row++) {
    const double flow = it->r[row] - it->q[row];
    it->r[row] = system->is_equation[row] ? e->rhs[row] - e->own * y[row] - e->shift * flow
                                          : e->rhs[row] - flow;
  }
}

/* One back-substitution: f, and how much of phi it is. */
static sct_status correct(sct_limited_iteration *it, const sct_limited_equation *e,
                          const sct_work *work, const double *phi, const double *y, bool linear,
                          double *change, sct_error *err) {
  const int64_t m = e->system->unknowns;
  sct_limited_iteration_correction(it, e->system, phi, y, work);
  if (linear) memset(it->q, 0, (size_t)m * sizeof *it->q);
  residual(it, e, y);
  const sct_status status = e->solve(e->context, it->r, it->f, err);
  if (status != SCT_OK) return status;
  const double size = largest(it->f, m);
  for (int64_t row = 0; row < m; row++) it->phi[e->system->point_of[row]] += it->f[row];
  *change = size > 0 ? size / largest(it->phi, e->system->n) : 0;
  return SCT_OK;
}

/* y = y + f */
static void step_plainly(sct_limited_iteration *it, int64_t m, double *y) {
  for (int64_t row = 0; row < m; row++) y[row] += it->f[row];
}

static void accelerate(sct_limited_iteration *it, pace *p, int64_t m, double change, double *y) {
  if (change < PROGRESS * p->least) {
    p->least = change;
    p->idle = 0;
    for (int64_t row = 0; row < m; row++) it->best[row] = y[row] + it->f[row];
  } else if (++p->idle >= PATIENCE) {
    *p = (pace){.is_plain = true};
    memcpy(y, it->best, (size_t)m * sizeof *y);
    return;
  }
  sct_anderson_step(it->anderson, it->f, y);
}

static void drift(sct_limited_iteration *it, pace *p, int64_t m, double change, double *y) {
  p->most = fmax(p->most, change);
  step_plainly(it, m, y);
  if (++p->idle < DRIFT || change > PASSED * p->most) return;
  *p = (pace){.least = INFINITY};
  sct_anderson_restart(it->anderson);
}

static void note(sct_limited_report *report, int64_t iteration, double change) {
  if (iteration <= SCT_LIMITED_HISTORY) report->history[iteration - 1] = change;
  report->iterations = iteration;
  report->residual = change;
  report->total++;
  if (iteration > report->most) report->most = iteration;
}

/* How far the change has come down, by powers of ten. */
static double fraction(double change, double tolerance) {
  return change < 1 ? fmin(1, log(change) / log(tolerance)) : 0;
}

static sct_status no_convergence(double change, int64_t k, double tolerance, sct_error *err) {
  return sct_fail(err, SCT_E_CONVERGENCE, -1,
                  "limited convection changes by %.2e of the solution in back-substitution "
                  "%" PRId64 ", the last one, needs %.2e",
                  change, k, tolerance);
}

sct_status sct_limited_iterate(sct_limited_iteration *it, const sct_limited_equation *e,
                               const sct_limited_options *options, const sct_work *work,
                               const char *phase, const double *phi, double *y,
                               sct_limited_report *report, sct_error *err) {
  const double asked = options->tolerance > 0 ? options->tolerance : SCT_LIMITED_TOLERANCE;
  const double tolerance = fmax(asked, ROUNDING);
  const int64_t most =
      options->max_iterations > 0 ? options->max_iterations : SCT_LIMITED_ITERATIONS;
  const int64_t m = e->system->unknowns;
  double change = INFINITY;
  pace p = {.least = INFINITY};
  sct_anderson_restart(it->anderson);
  for (int64_t k = 1; k <= most; k++) {
    const bool linear = k == 1 && e->starts_linear;
    sct_status status = correct(it, e, work, phi, y, linear, &change, err);
    const bool overflows = status == SCT_E_NOT_FINITE && k > 1; /* data are finite: y is not */
    if (overflows) return no_convergence(change, k, tolerance, err);
    if (status != SCT_OK) return status;
    note(report, k, change);
    sct_work_residual(work, change);
    if (phase != NULL) {
      status = sct_work_report(work, phase, fraction(change, tolerance), err);
      if (status != SCT_OK) return status;
    }
    if (linear || change <= tolerance) {
      step_plainly(it, m, y);
    } else if (p.is_plain) {
      drift(it, &p, m, change, y);
    } else {
      accelerate(it, &p, m, change, y);
    }
    if (change <= tolerance && !linear) return SCT_OK;
  }
  return no_convergence(change, most, tolerance, err);
}

void sct_limited_relax(sct_solve_options *solve) {
  const bool chooses = solve->method == NULL || strcmp(solve->method, "auto") == 0;
  if (chooses && solve->dim < 3) solve->method = "direct";
  solve->backward_error = fmax(solve->backward_error, 1e-8);
  solve->tolerance = 1e-4;
  solve->work = NULL; /* residuals are told of the iteration around it */
}

static sct_status substitute(void *solver, const double *r, double *x, sct_error *err) {
  return sct_solver_solve(solver, r, false, x, err);
}

sct_status sct_limited_solve(const sct_system *system, sct_solver *solver,
                             const sct_limited_options *options, const sct_work *work, double *phi,
                             sct_limited_report *report, sct_error *err) {
  const int64_t m = system->unknowns;
  sct_limited_report unread;
  sct_limited_iteration *it = NULL;
  double *y = NULL, *rhs = NULL;
  if (report == NULL) report = &unread;
  *report = (sct_limited_report){0};
  sct_status status = sct_limited_iteration_new(system, &it, err);
  if (status == SCT_OK) status = sct_alloc(&y, m, sizeof *y, err);
  if (status == SCT_OK) status = sct_alloc(&rhs, m, sizeof *rhs, err);
  if (status != SCT_OK) goto done;
  const sct_limited_equation equation = {.system = system,
                                         .shift = 1,
                                         .rhs = rhs,
                                         .starts_linear = true,
                                         .solve = substitute,
                                         .context = solver};
  for (int64_t row = 0; row < m; row++) y[row] = phi[system->point_of[row]];
  sct_system_rhs(system, phi, rhs);
  status = sct_limited_iterate(it, &equation, options, work, "solve", phi, y, report, err);
  for (int64_t row = 0; row < m; row++) phi[system->point_of[row]] = y[row];
done:
  sct_limited_iteration_free(&it);
  sct_release(&y);
  sct_release(&rhs);
  return status;
}
