/* Both sweeps go over the levels of a tape; what they share is a level: its weights, the system at
 * its time, its matrix, factored. */
#include "scatter/adjoint.h"

#include <math.h>
#include <string.h>

#include "alloc.h"
#include "march_matrix.h"
#include "march_scheme.h"

typedef struct {
  const sct_replay *replay;
  int64_t unknowns;
  sct_march_matrix *matrix; /* of the steps */
  sct_march_matrix *start;  /* of level 0, where conditions are imposed on it */
  double shift;             /* of the factored matrix, NaN: none */
  double *scratch;          /* [n] for Dirichlet values nobody needs */
  double *work;             /* [4][unknowns] */
} sweep;

static const sct_system *system_of(const sweep *s) {
  return *s->replay->system;
}

static const double *values_at(const sct_tape *tape, int64_t k) {
  return tape->phi == NULL ? NULL : tape->phi + k * tape->n;
}

/* Weights of the step that led to level k; of level 0 those of none. */
static sct_march_weights weights_of(const sweep *s, int64_t k) {
  const sct_tape *tape = s->replay->tape;
  if (k <= 0 || k >= tape->levels) return (sct_march_weights){0};
  const double ratio = k == 1 ? 0 : tape->dt[k] / tape->dt[k - 1];
  return sct_march_weigh(s->replay->options->method, ratio);
}

static sct_status sweep_new(const sct_replay *replay, sweep *s, sct_error *err) {
  const sct_system *system = *replay->system;
  const bool explicit = replay->options->method == SCT_FORWARD_EULER;
  *s = (sweep){.replay = replay, .unknowns = system->unknowns, .shift = NAN};
  sct_status status = sct_alloc(&s->scratch, system->n, sizeof(double), err);
  if (status == SCT_OK) {
    status = sct_alloc_zero(&s->work, s->unknowns, 4 * sizeof(double), err);
  }
  if (status == SCT_OK) status = sct_march_matrix_new(system, explicit, &s->matrix, err);
  if (status == SCT_OK && replay->tape->is_settled) {
    status = sct_march_matrix_new(system, true, &s->start, err);
  }
  return status;
}

static void sweep_clear(sweep *s) {
  sct_march_matrix_free(&s->matrix);
  sct_march_matrix_free(&s->start);
  sct_release(&s->scratch);
  sct_release(&s->work);
}

/* Brings the system to the time of level k. */
static sct_status visit(sweep *s, int64_t k, sct_error *err) {
  const sct_march_problem *p = s->replay->problem;
  if (p == NULL || p->varies == 0) return SCT_OK;
  if (p->varies & SCT_VARIES_MATRIX) s->shift = NAN;
  return p->advance(p->context, s->replay->tape->t[k], s->replay->system, s->scratch, err);
}

/* The factored matrix of level k; NULL: the identity. */
static sct_status matrix_of(sweep *s, int64_t k, sct_march_matrix **matrix, sct_error *err) {
  const double shift = weights_of(s, k).implicit * s->replay->tape->dt[k];
  *matrix = k == 0 ? s->start : s->matrix;
  if (*matrix == NULL) return SCT_OK;
  if (k == 0) {
    return sct_march_matrix_factor(s->start, system_of(s), 0, &s->replay->options->solve, err);
  }
  if (s->shift == shift) return SCT_OK;
  sct_status status =
      sct_march_matrix_factor(s->matrix, system_of(s), shift, &s->replay->options->solve, err);
  s->shift = status == SCT_OK ? shift : NAN;
  return status;
}

static sct_status tell(const sweep *s, const char *phase, int64_t done, sct_error *err) {
  return sct_work_report(s->replay->work, phase, (double)done / (double)s->replay->tape->levels,
                         err);
}

/* ---- Tangent ---- */

/* rhs = now y'_k-1 + before y'_k-2 + old - theta dt R'_k, condition rows -R'_k; `old` is what level
 * k-1 put aside, - e dt (A y' + R'). At level 0 `now` is 1. */
static void tangent_rhs(const sweep *s, int64_t k, const double *y, const double *before,
                        const double *slope, double *old) {
  const sct_march_weights w = weights_of(s, k);
  const double now = k == 0 ? 1 : w.now, dt = s->replay->tape->dt[k];
  for (int64_t i = 0; i < s->unknowns; i++) {
    if (system_of(s)->is_equation[i]) {
      old[i] += now * y[i] + w.before * before[i] - w.implicit * dt * slope[i];
    } else {
      old[i] = -slope[i];
    }
  }
}

/* old = - e dt (A y' + R') of level k for the step after it; slope is used up. */
static void put_aside(const sweep *s, int64_t k, const double *y, double *slope, double *old) {
  const double factor = k + 1 < s->replay->tape->levels
                            ? weights_of(s, k + 1).explicit * s->replay->tape->dt[k + 1]
                            : 0;
  if (factor != 0) sct_csr_multiply_add(system_of(s)->matrix, 1, y, slope);
  for (int64_t i = 0; i < s->unknowns; i++) old[i] = factor == 0 ? 0 : -factor * slope[i];
}

static sct_status tangent_level(sweep *s, int64_t k, sct_tangent_slope *slope, void *context,
                                double *y[3], sct_error *err) {
  const sct_tape *tape = s->replay->tape;
  double *r = s->work + 3 * s->unknowns, *rhs = y[2];
  sct_march_matrix *matrix;
  sct_status status = visit(s, k, err);
  if (status == SCT_OK) status = slope(context, tape->t[k], values_at(tape, k), r, err);
  if (status == SCT_OK) status = matrix_of(s, k, &matrix, err);
  if (status != SCT_OK) return status;
  if (matrix != NULL) {
    tangent_rhs(s, k, y[0], y[1], r, rhs);
    status = sct_march_matrix_solve(matrix, system_of(s), rhs, y[1], err);
    if (status != SCT_OK) return status;
    double *newest = y[1];
    y[1] = y[0];
    y[0] = newest;
  }
  put_aside(s, k, y[0], r, rhs);
  return tell(s, "tangent", k + 1, err);
}

sct_status sct_march_tangent(const sct_replay *replay, sct_tangent_slope *slope, void *context,
                             double *phi, sct_error *err) {
  sweep s;
  sct_status status = sweep_new(replay, &s, err);
  if (status != SCT_OK) goto done;
  double *y[3] = {s.work, s.work + s.unknowns, s.work + 2 * s.unknowns};
  for (int64_t i = 0; i < s.unknowns; i++) y[0][i] = phi[system_of(&s)->point_of[i]];
  for (int64_t k = 0; status == SCT_OK && k < replay->tape->levels; k++) {
    status = tangent_level(&s, k, slope, context, y, err);
  }
  if (status != SCT_OK) goto done;
  for (int64_t i = 0; i < s.unknowns; i++) phi[system_of(&s)->point_of[i]] = y[0][i];
done:
  sweep_clear(&s);
  return status;
}

/* ---- Adjoint ---- */

/* What the sweep carries down: lambda of the two levels above, each [unknowns]. */
typedef struct {
  double *y;     /* what later levels hand to this one, then its lambda */
  double *above; /* lambda one level up, equation rows; condition rows 0 */
  double *far;   /* two levels up */
  double *kappa;
} falling;

/* y += now lambda_k+1 + before lambda_k+2 - (e dt A^T lambda)_k+1; kappa = (e dt lambda)_k+1 */
static void hand_down(const sweep *s, int64_t k, const falling *f) {
  const sct_march_weights next = weights_of(s, k + 1), second = weights_of(s, k + 2);
  const double factor =
      k + 1 < s->replay->tape->levels ? next.explicit * s->replay->tape->dt[k + 1] : 0;
  for (int64_t i = 0; i < s->unknowns; i++) {
    f->kappa[i] = factor * f->above[i];
    f->y[i] += next.now * f->above[i] + second.before * f->far[i];
  }
  if (factor != 0) sct_csr_multiply_transposed_add(system_of(s)->matrix, -1, f->kappa, f->y);
}

/* kappa of (3) from lambda in y; leaves lambda with its condition rows 0. */
static void weigh_down(const sweep *s, int64_t k, const falling *f) {
  const double shift = weights_of(s, k).implicit * s->replay->tape->dt[k];
  for (int64_t i = 0; i < s->unknowns; i++) {
    const bool equation = system_of(s)->is_equation[i] != 0;
    f->kappa[i] += equation ? shift * f->y[i] : f->y[i];
    if (!equation) f->y[i] = 0;
  }
}

static sct_status adjoint_level(sweep *s, int64_t k, sct_adjoint_absorb *absorb, void *context,
                                falling *f, sct_error *err) {
  const sct_tape *tape = s->replay->tape;
  sct_march_matrix *matrix;
  sct_status status = visit(s, k, err);
  if (status == SCT_OK) status = matrix_of(s, k, &matrix, err);
  if (status != SCT_OK) return status;
  hand_down(s, k, f);
  if (matrix != NULL) {
    status = sct_march_matrix_solve_transposed(matrix, system_of(s), f->y, f->far, err);
    if (status != SCT_OK) return status;
    memcpy(f->y, f->far, (size_t)s->unknowns * sizeof *f->y);
    weigh_down(s, k, f);
  }
  status = absorb(context, tape->t[k], values_at(tape, k), f->kappa, err);
  if (status == SCT_OK) status = tell(s, "adjoint", tape->levels - k, err);
  return status;
}

/* y becomes `above` of the level below, which begins with nothing. */
static void descend(const sweep *s, falling *f) {
  double *freed = f->far;
  f->far = f->above;
  f->above = f->y;
  f->y = freed;
  memset(f->y, 0, (size_t)s->unknowns * sizeof *f->y);
}

sct_status sct_march_adjoint(const sct_replay *replay, sct_adjoint_absorb *absorb, void *context,
                             double *phi, sct_error *err) {
  sweep s;
  sct_status status = sweep_new(replay, &s, err);
  if (status != SCT_OK) goto done;
  const int64_t m = s.unknowns, n = system_of(&s)->n;
  falling f = {s.work, s.work + m, s.work + 2 * m, s.work + 3 * m};
  for (int64_t i = 0; i < m; i++) f.y[i] = phi[system_of(&s)->point_of[i]];
  for (int64_t k = replay->tape->levels - 1; status == SCT_OK && k >= 0; k--) {
    status = adjoint_level(&s, k, absorb, context, &f, err);
    if (status == SCT_OK && k > 0) descend(&s, &f);
  }
  if (status != SCT_OK) goto done;
  memset(phi, 0, (size_t)n * sizeof *phi);
  for (int64_t i = 0; i < m; i++) phi[system_of(&s)->point_of[i]] = f.y[i];
done:
  sweep_clear(&s);
  return status;
}
