#include "march_growth.h"

#include <math.h>

#include "alloc.h"

/* Sum and sum of absolute values of row i, columns of Dirichlet points included. */
static void sum_row(const sct_system *system, int64_t i, double *sum, double *size) {
  const sct_csr *const parts[] = {system->matrix, system->coupling};
  *sum = *size = 0;
  for (int p = 0; p < 2; p++) {
    for (int64_t k = parts[p]->start[i]; k < parts[p]->start[i + 1]; k++) {
      *sum += parts[p]->value[k];
      *size += fabs(parts[p]->value[k]);
    }
  }
}

static double diagonal(const sct_csr *a, int64_t i) {
  for (int64_t k = a->start[i]; k < a->start[i + 1]; k++) {
    if (a->column[k] == i) return a->value[k];
  }
  return 0;
}

/* lift of the condition rows; returns how much the worst of them amplifies what it averages. */
static double condition_rows(sct_march_growth *g, const sct_system *system) {
  double excess = 0;
  for (int64_t i = 0; i < system->unknowns; i++) {
    g->lift[i] = 0;
    if (system->is_equation[i]) continue;
    double sum, size;
    sum_row(system, i, &sum, &size);
    g->lift[i] = size > 0 ? 2 / size : 0;
    excess = fmax(excess, -copysign(g->lift[i], diagonal(system->matrix, i)) * sum);
  }
  return excess;
}

static double size_of_conditions(const sct_march_growth *g, const sct_csr *a, int64_t i) {
  double size = 0;
  for (int64_t k = a->start[i]; k < a->start[i + 1]; k++) {
    if (g->lift[a->column[k]] > 0) size += fabs(a->value[k]);
  }
  return size;
}

sct_status sct_march_growth_matrix(sct_march_growth *g, const sct_system *system, sct_error *err) {
  const double excess = condition_rows(g, system);
  g->growth = g->carry = 0;
  for (int64_t i = 0; i < system->unknowns; i++) {
    double sum, size;
    sum_row(system, i, &sum, &size);
    if (!isfinite(size)) {
      return sct_fail(err, SCT_E_NOT_FINITE, system->point_of[i],
                      "has a matrix row that is not finite");
    }
    if (!system->is_equation[i]) continue;
    const double carry = size_of_conditions(g, system->matrix, i);
    g->growth = fmax(g->growth, carry * excess - sum);
    g->carry = fmax(g->carry, carry);
  }
  return SCT_OK;
}

sct_status sct_march_growth_load(sct_march_growth *g, const sct_system *system, sct_error *err) {
  double source = 0;
  g->least = 0;
  for (int64_t i = 0; i < system->unknowns; i++) {
    const double size = fabs(system->load[i]);
    if (!isfinite(size)) {
      return sct_fail(err, SCT_E_NOT_FINITE, system->point_of[i],
                      "has a source or boundary value that is not finite");
    }
    if (system->is_equation[i]) {
      source = fmax(source, size);
    } else {
      g->least = fmax(g->least, g->lift[i] * size);
    }
  }
  g->earlier = g->source;
  g->source = source + g->carry * g->least;
  return SCT_OK;
}

sct_status sct_march_growth_new(const sct_system *system, const double *phi, sct_march_growth *g,
                                sct_error *err) {
  *g = (sct_march_growth){0};
  sct_status status = sct_alloc(&g->lift, system->unknowns, sizeof *g->lift, err);
  if (status == SCT_OK) status = sct_march_growth_matrix(g, system, err);
  if (status == SCT_OK) status = sct_march_growth_load(g, system, err);
  for (int64_t p = 0; status == SCT_OK && p < system->n; p++) {
    g->bound = fmax(g->bound, fabs(phi[p]));
    if (!isfinite(phi[p])) {
      status = sct_fail(err, SCT_E_NOT_FINITE, p, "has an initial value that is not finite");
    }
  }
  if (status != SCT_OK) sct_march_growth_free(g);
  return status;
}

void sct_march_growth_free(sct_march_growth *g) {
  sct_release(&g->lift);
}

/* Where |phi| is largest among unknowns (is_given false) or Dirichlet points; -1 if all are zero.
 * NaN counts as infinity. */
static double largest(const sct_system *system, const double *phi, bool is_given, int64_t *at) {
  double worst = 0;
  *at = -1;
  for (int64_t p = 0; p < system->n; p++) {
    const double size = isnan(phi[p]) ? INFINITY : fabs(phi[p]);
    if ((system->row_of[p] < 0) == is_given && size > worst) {
      worst = size;
      *at = p;
    }
  }
  return worst;
}

sct_status sct_march_growth_check(sct_march_growth *g, const sct_system *system, const double *phi,
                                  double t, double dt, const char *advice, sct_error *err) {
  int64_t at;
  const double given = largest(system, phi, true, &at);
  if (!isfinite(given)) {
    return sct_fail(err, SCT_E_NOT_FINITE, at, "has a value at t = %.9g that is not finite", t);
  }
  g->bound = (g->bound + fmax(g->source, g->earlier) * dt) * exp(g->growth * dt);
  g->bound = fmax(fmax(g->bound, given), g->least);
  g->earlier = g->source;
  const double got = largest(system, phi, false, &at);
  if (got <= fmin(SCT_GROWTH_LIMIT * g->bound, SCT_GROWTH_END)) return SCT_OK;
  return sct_fail(err, SCT_E_UNSTABLE, at,
                  "has |phi| = %.3g at t = %.9g with step %.6g, where initial values, "
                  "sources and boundary values account for %.3g: %s",
                  got, t, dt, g->bound, advice);
}
