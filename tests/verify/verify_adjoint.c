/* Tangent and adjoint of a march against differences of the march, and against each other. */
#include "equation.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "../near.h"
#include "../seed.h"

/* The problem at data + h change. With `varies`, all data but the initial values are multiplied by
 * 1 + t^2 / 2 (the slopes of rows with them). */
typedef struct {
  const equation *e;
  double h;
  bool varies;
  equation_data now;
  sct_slope *slope;          /* at the time of the system */
  double at;                 /* its time */
  sct_data gradient, change; /* of a sweep; the change at its time */
} problem;

static double stretch(const problem *p, double t) {
  return p->varies ? 1 + 0.5 * t * t : 1;
}

static void scale(sct_data *d, const equation *e, double factor) {
  double *const arrays[] = {d->velocity, d->diffusivity, d->source,
                            d->reaction, d->value,       d->coefficient};
  for (int k = 0; k < 6; k++) {
    for (int64_t i = 0; i < (k == 0 ? e->n * e->dim : e->n); i++) arrays[k][i] *= factor;
  }
}

static void set_time(problem *p, double t) {
  equation_data_clear(&p->now);
  p->now = equation_at(p->e, p->h);
  scale(&p->now.at, p->e, stretch(p, t));
  p->at = t;
}

static sct_status advance(void *context, double t, sct_system **system, double *phi,
                          sct_error *err) {
  problem *p = context;
  sct_system *next = NULL;
  set_time(p, t);
  sct_status status =
      sct_system_build(p->e->f.stencil, &p->now.fields, &p->now.boundary, NULL, &next, err);
  if (status != SCT_OK) return status;
  sct_system_free(system);
  *system = next;
  for (int64_t i = 0; i < p->e->n; i++) {
    if (next->row_of[i] < 0) phi[i] = p->now.at.value[i];
  }
  return SCT_OK;
}

static problem problem_make(const equation *e, double h, bool varies) {
  return (problem){.e = e, .h = h, .varies = varies, .now = equation_at(e, h)};
}

static sct_march_problem in_time(problem *p) {
  const int all = SCT_VARIES_MATRIX | SCT_VARIES_LOAD | SCT_VARIES_DIRICHLET;
  return (sct_march_problem){p->varies ? all : 0, p, advance, NULL};
}

/* phi at the end for data + h change and initial values likewise. The system is that of the end. */
static sct_system *march(problem *p, const sct_march_options *o, sct_tape *tape, double *phi) {
  const equation *e = p->e;
  sct_error err;
  sct_system *system = equation_system(e, p->h);
  for (int64_t i = 0; i < e->n; i++) {
    phi[i] = e->initial[i] + p->h * e->initial_change[i];
    if (system->row_of[i] < 0) phi[i] = p->now.at.value[i];
  }
  const sct_march_problem of = in_time(p);
  sct_march_options recorded = *o;
  recorded.tape = tape;
  expect_ok(sct_march(&system, &recorded, &of, NULL, phi, NULL, &err), &err);
  return system;
}

/* weight . phi(h) */
static double number_at(const equation *e, double h, bool varies, const sct_march_options *o,
                        const double *weight) {
  problem p = problem_make(e, h, varies);
  double *phi = fixture_alloc(e->n, sizeof *phi), sum = 0;
  sct_system *system = march(&p, o, NULL, phi);
  for (int64_t i = 0; i < e->n; i++) sum += weight[i] * phi[i];
  sct_system_free(&system);
  equation_data_clear(&p.now);
  free(phi);
  return sum;
}

/* Slopes at time t, where the system is. */
static sct_status take_slope(problem *p, const sct_system *system, double t, sct_error *err) {
  if (p->slope != NULL && !p->varies) return SCT_OK;
  sct_slope_free(&p->slope);
  equation_free(&p->change);
  p->change = equation_zeros(p->e);
  equation_data twice = equation_at(p->e, 1), once = equation_at(p->e, 0);
  scale(&once.at, p->e, -1);
  double *const to[] = {p->change.velocity, p->change.diffusivity, p->change.source,
                        p->change.reaction, p->change.value,       p->change.coefficient};
  double *const a[] = {twice.at.velocity, twice.at.diffusivity, twice.at.source,
                       twice.at.reaction, twice.at.value,       twice.at.coefficient};
  double *const b[] = {once.at.velocity, once.at.diffusivity, once.at.source,
                       once.at.reaction, once.at.value,       once.at.coefficient};
  for (int k = 0; k < 6; k++) {
    for (int64_t i = 0; i < (k == 0 ? p->e->n * p->e->dim : p->e->n); i++) {
      to[k][i] = (a[k][i] + b[k][i]) * stretch(p, t);
    }
  }
  equation_data_clear(&twice);
  equation_data_clear(&once);
  return sct_slope_build(p->e->f.stencil, &p->now.fields, system, true, NULL, &p->slope, err);
}

typedef struct {
  problem *p;
  sct_system **system;
  double dot; /* -kappa . R' summed, by way of the gradient */
} sweeper;

static sct_status slope_at(void *context, double t, const double *phi, double *r, sct_error *err) {
  const sweeper *s = context;
  sct_status status = take_slope(s->p, *s->system, t, err);
  if (status == SCT_OK) sct_slope_apply(s->p->slope, *s->system, &s->p->change, phi, r);
  return status;
}

static sct_status absorb(void *context, double t, const double *phi, const double *kappa,
                         sct_error *err) {
  sweeper *s = context;
  sct_status status = take_slope(s->p, *s->system, t, err);
  if (status != SCT_OK) return status;
  sct_data gradient = equation_zeros(s->p->e);
  sct_slope_apply_transposed(s->p->slope, *s->system, -1, kappa, phi, &gradient);
  s->dot += equation_dot(s->p->e, &gradient, &s->p->change);
  equation_free(&gradient);
  return SCT_OK;
}

/* weight at Dirichlet points times the change of their values at the end */
static double direct_part(const problem *p, const sct_system *system, const double *weight) {
  double sum = 0;
  for (int64_t i = 0; i < p->e->n; i++) {
    if (system->row_of[i] < 0) sum += weight[i] * p->change.value[i];
  }
  return sum;
}

static void check(const equation *e, const sct_march_options *o, bool varies, uint64_t *seed) {
  sct_error err;
  sct_tape tape = {.keeps_values = true};
  problem p = problem_make(e, 0, varies);
  p.change = equation_zeros(e);
  double *weight = fixture_alloc(e->n, sizeof *weight), *phi = fixture_alloc(e->n, sizeof *phi);
  for (int64_t i = 0; i < e->n; i++) weight[i] = seed_uniform(seed, -1, 1);
  sct_system *system = march(&p, o, &tape, phi);
  const sct_march_problem of = in_time(&p);
  const sct_replay replay = {&tape, o, &system, &of, NULL};
  sweeper s = {&p, &system, 0};
  memcpy(phi, e->initial_change, (size_t)e->n * sizeof *phi);
  expect_ok(sct_march_tangent(&replay, slope_at, &s, phi, &err), &err);
  double tangent = direct_part(&p, system, weight);
  for (int64_t i = 0; i < system->unknowns; i++) {
    tangent += weight[system->point_of[i]] * phi[system->point_of[i]];
  }
  double adjoint = direct_part(&p, system, weight);
  memcpy(phi, weight, (size_t)e->n * sizeof *phi);
  expect_ok(sct_march_adjoint(&replay, absorb, &s, phi, &err), &err);
  adjoint += s.dot;
  for (int64_t i = 0; i < e->n; i++) adjoint += phi[i] * e->initial_change[i];
  const double h = 1e-3, far = number_at(e, 2 * h, varies, o, weight),
               near = number_at(e, h, varies, o, weight);
  const double back = number_at(e, -h, varies, o, weight),
               farther = number_at(e, -2 * h, varies, o, weight);
  const double differences = (8 * (near - back) - (far - farther)) / (12 * h);
  printf("%-15s %d-D %s %lld levels  differences %.2e  adjoint %.2e\n", sct_march_name(o->method),
         e->dim, varies ? "varies" : "      ", (long long)tape.levels,
         fabs(tangent - differences) / fabs(tangent), fabs(tangent - adjoint) / fabs(tangent));
  assert_near(tangent, differences, 1e-8 * (1 + fabs(tangent)));
  assert_near(adjoint, tangent, 1e-12 * (1 + fabs(tangent)));
  sct_system_free(&system);
  sct_slope_free(&p.slope);
  equation_free(&p.change);
  equation_data_clear(&p.now);
  sct_tape_clear(&tape);
  free(weight);
  free(phi);
}

static void every_scheme(bool varies, int dim) {
  uint64_t seed = seed_new("adjoint");
  static const double steps[SCT_MARCH_COUNT] = {5e-4, 0.01, 0.01, 0.01};
  sct_operator op = sct_operator_default(SCT_IPS, 2);
  op.upwind = SCT_UPWIND_COSINE;
  equation e = equation_make(dim, &op, false, 11);
  for (int k = 0; k < SCT_MARCH_COUNT; k++) {
    /* save times that no step divides: steps of several lengths, one more than twice as long */
    const sct_march_options o = {
        .method = (sct_march_method)k,
        .start = 0.1,
        .end = 0.1 + 12 * steps[k],
        .step = steps[k],
        .save = (const double[]){0.1 + 3.4 * steps[k], 0.1 + 3.8 * steps[k]},
        .saves = 2,
        .solve = {.dim = dim, .method = "auto"}};
    check(&e, &o, varies, &seed);
  }
  equation_clear(&e);
}

static void constant_in_1d(void **state) {
  (void)state;
  every_scheme(false, 1);
}
static void constant_in_2d(void **state) {
  (void)state;
  every_scheme(false, 2);
}
static void varying_in_1d(void **state) {
  (void)state;
  every_scheme(true, 1);
}
static void varying_in_2d(void **state) {
  (void)state;
  every_scheme(true, 2);
}

static void long_tape_is_refused(void **state) {
  (void)state;
  sct_operator op = sct_operator_default(SCT_IPS, 2);
  equation e = equation_make(1, &op, true, 3);
  sct_system *system = equation_system(&e, 0);
  sct_error err;
  sct_tape tape = {.keeps_values = true, .most_bytes = 1000};
  problem p = problem_make(&e, 0, false);
  const sct_march_problem of = in_time(&p);
  const sct_march_options o = {.method = SCT_BACKWARD_EULER, .end = 1, .step = 1e-3, .tape = &tape};
  assert_int_equal(sct_march(&system, &o, &of, NULL, e.initial, NULL, &err), SCT_E_LIMIT);
  assert_int_equal(tape.levels, 0);
  sct_system_free(&system);
  equation_data_clear(&p.now);
  equation_clear(&e);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(constant_in_1d),       cmocka_unit_test(constant_in_2d),
      cmocka_unit_test(varying_in_1d),        cmocka_unit_test(varying_in_2d),
      cmocka_unit_test(long_tape_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
