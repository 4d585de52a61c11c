/* Every allocation of slopes, tapes, tangent and adjoint sweeps fails once: the answer is
 * SCT_E_MEMORY and nothing leaks. */
#include <stdlib.h>
#include <string.h>

#include "../verify/equation.h"
#include "scarce.h"

typedef struct {
  const equation *e;
  const equation_data *data;
  sct_system *system;
  sct_march_method method;
  double *phi; /* [n] */
} scenario;

typedef struct {
  scenario *s;
  sct_slope *slope;
} sweeper;

static sct_status slope_at(void *context, double t, const double *phi, double *r, sct_error *err) {
  const sweeper *w = context;
  (void)t, (void)err;
  sct_slope_apply(w->slope, w->s->system, &w->s->e->change, phi, r);
  return SCT_OK;
}

static sct_status absorb(void *context, double t, const double *phi, const double *kappa,
                         sct_error *err) {
  const sweeper *w = context;
  sct_data gradient = w->s->data->at;
  (void)t, (void)err;
  sct_slope_apply_transposed(w->slope, w->s->system, -1, kappa, phi, &gradient);
  return SCT_OK;
}

/* Forward, recorded, and both ways again. */
static sct_status run(scenario *s, sct_error *err) {
  sct_tape tape = {.keeps_values = true};
  const sct_march_options o = {
      .method = s->method, .end = 0.003, .step = 0.001, .solve = {.dim = 2}, .tape = &tape};
  const sct_replay replay = {&tape, &o, &s->system, NULL, NULL};
  sweeper w = {s, NULL};
  memcpy(s->phi, s->e->initial, (size_t)s->e->n * sizeof *s->phi);
  sct_status status =
      sct_slope_build(s->e->f.stencil, &s->data->fields, s->system, true, NULL, &w.slope, err);
  if (status != SCT_OK) assert_null(w.slope);
  if (status == SCT_OK) status = sct_march(&s->system, &o, NULL, NULL, s->phi, NULL, err);
  if (status == SCT_OK) status = sct_march_tangent(&replay, slope_at, &w, s->phi, err);
  if (status == SCT_OK) status = sct_march_adjoint(&replay, absorb, &w, s->phi, err);
  sct_tape_clear(&tape);
  sct_slope_free(&w.slope);
  return status;
}

static void fail_each(scenario *s) {
  sct_error err = {0};
  int failures = 0;
  expect_ok(run(s, &err), &err);
  for (int64_t n = 0;; n++) {
    err = (sct_error){0};
    scarce_after(n, false);
    const sct_status status = run(s, &err);
    const bool hit = scarce_end();
    if (status != SCT_OK) {
      assert_int_equal(status, SCT_E_MEMORY);
      assert_int_equal(err.code, SCT_E_MEMORY);
      failures++;
    }
    if (!hit) break;
  }
  assert_in_range(failures, 30, 1000);
}

static void sweeps(void **state) {
  (void)state;
  const sct_operator op = sct_operator_default(SCT_IPS, 2);
  equation e = equation_make(2, &op, false, 4);
  equation_data data = equation_at(&e, 0);
  for (int k = 0; k < SCT_MARCH_COUNT; k++) {
    scenario s = {&e, &data, equation_system(&e, 0), (sct_march_method)k, NULL};
    s.phi = fixture_alloc(e.n, sizeof *s.phi);
    fail_each(&s);
    free(s.phi);
    sct_system_free(&s.system);
  }
  equation_data_clear(&data);
  equation_clear(&e);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(sweeps)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
