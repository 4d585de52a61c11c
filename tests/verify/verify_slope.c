/* The slope of a system's rows against differences of the assembled residual, and its transpose
 * against itself. */
#include "equation.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "../near.h"
#include "../seed.h"

/* R(phi; data + h change), phi at Dirichlet points being their values. */
static void residual(const equation *e, double h, const double *phi, double *r) {
  sct_system *system = equation_system(e, h);
  equation_data d = equation_at(e, h);
  double *all = fixture_alloc(e->n, sizeof *all), *y = fixture_alloc(e->n, sizeof *y);
  for (int64_t i = 0; i < e->n; i++) all[i] = system->row_of[i] < 0 ? d.at.value[i] : phi[i];
  for (int64_t k = 0; k < system->unknowns; k++) y[k] = phi[system->point_of[k]];
  sct_system_rhs(system, all, r);
  for (int64_t k = 0; k < system->unknowns; k++) r[k] = -r[k];
  sct_csr_multiply_add(system->matrix, 1, y, r);
  free(all);
  free(y);
  equation_data_clear(&d);
  sct_system_free(&system);
}

/* Differences of fourth order: truncation h^4, rounding 1e-16 / h. */
static void differences(const equation *e, const double *phi, double *slope) {
  static const double at[] = {-2, -1, 1, 2}, weight[] = {1. / 12, -2. / 3, 2. / 3, -1. / 12};
  const double h = 1e-3;
  double *r = fixture_alloc(e->n, sizeof *r);
  for (int k = 0; k < 4; k++) {
    residual(e, at[k] * h, phi, r);
    for (int64_t i = 0; i < e->n; i++) slope[i] += weight[k] / h * r[i];
  }
  free(r);
}

static double largest(const double *x, int64_t n) {
  double most = 0;
  for (int64_t i = 0; i < n; i++) most = fmax(most, fabs(x[i]));
  return most;
}

/* Returns the largest difference, relative to the largest slope. */
static double check(const equation *e, uint64_t *seed) {
  sct_error err;
  sct_slope *slope = NULL;
  sct_system *system = equation_system(e, 0);
  equation_data d = equation_at(e, 0);
  double *phi = fixture_alloc(e->n, sizeof *phi), *r = fixture_alloc(e->n, sizeof *r);
  double *by_steps = fixture_alloc(e->n, sizeof *r), *weight = fixture_alloc(e->n, sizeof *r);
  for (int64_t i = 0; i < e->n; i++) phi[i] = seed_uniform(seed, -1, 1);
  for (int64_t i = 0; i < e->n; i++) weight[i] = seed_uniform(seed, -1, 1);
  for (int64_t i = 0; i < e->n; i++) phi[i] = system->row_of[i] < 0 ? d.at.value[i] : phi[i];
  expect_ok(sct_slope_build(e->f.stencil, &d.fields, system, true, NULL, &slope, &err), &err);
  sct_slope_apply(slope, system, &e->change, phi, r);
  differences(e, phi, by_steps);
  double worst = 0, dot = 0;
  for (int64_t i = 0; i < system->unknowns; i++) {
    worst = fmax(worst, fabs(r[i] - by_steps[i]));
    dot += weight[i] * r[i];
  }
  sct_data gradient = equation_zeros(e);
  sct_slope_apply_transposed(slope, system, 1, weight, phi, &gradient);
  const double scale = largest(r, system->unknowns);
  assert_near(equation_dot(e, &gradient, &e->change), dot, 1e-12 * scale * (double)e->n);
  equation_free(&gradient);
  equation_data_clear(&d);
  sct_slope_free(&slope);
  sct_system_free(&system);
  free(phi);
  free(r);
  free(by_steps);
  free(weight);
  return worst / scale;
}

static void every_operator(void **state) {
  (void)state;
  uint64_t seed = seed_new("slope");
  static const struct {
    sct_scheme scheme;
    sct_upwind upwind;
  } rows[] = {{SCT_IPS, SCT_UPWIND_NONE},    {SCT_IPS, SCT_UPWIND_EXACT},
              {SCT_IPS, SCT_UPWIND_COSINE},  {SCT_LSMPS, SCT_UPWIND_NONE},
              {SCT_LSMPS, SCT_UPWIND_EXACT}, {SCT_MPS, SCT_UPWIND_COSINE},
              {SCT_PS, SCT_UPWIND_EXACT},    {SCT_IPSN, SCT_UPWIND_COSINE}};
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    for (int dim = 1; dim <= 3; dim++) {
      sct_operator op = sct_operator_default(rows[k].scheme, 2);
      op.upwind = rows[k].upwind;
      equation e = equation_make(dim, &op, false, (uint64_t)seed_below(&seed, 1000));
      const double worst = check(&e, &seed);
      printf("%-6s %-7s %d-D  %.1e\n", sct_scheme_name(op.scheme), sct_upwind_name(op.upwind), dim,
             worst);
      assert_true(worst < 1e-9);
      equation_clear(&e);
    }
  }
}

static void nothing_moves_yet(void **state) {
  (void)state;
  uint64_t seed = seed_new("slope");
  sct_operator op = sct_operator_default(SCT_IPS, 2);
  equation e = equation_make(2, &op, true, 5);
  assert_true(check(&e, &seed) < 1e-9);
  equation_clear(&e);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_operator),
      cmocka_unit_test(nothing_moves_yet),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
