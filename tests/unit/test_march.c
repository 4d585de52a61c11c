/* The march around its schemes: plan, stops, detection of unstable steps, failures. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "../heat.h"
#include "../near.h"
#include "march_scheme.h"
#include "scatter/march.h"

enum { POINTS = 11 };
static const double pi = 3.14159265358979323846;
static const heat rod = {POINTS, SCT_DIRICHLET, SCT_DIRICHLET, 0.5, 0, 0, 0};

/* What the callbacks saw. */
typedef struct {
  double save_time[16], advance_time[64], report[64];
  int saves, advances, reports;
  int cancel_at, fail_save, fail_advance; /* call at which to answer badly, 0: never */
  sct_system *system;
  double feed; /* reaction set by advance */
} witness;

static sct_status see_save(void *context, double t, const double *phi, sct_error *err) {
  witness *w = context;
  assert_non_null(phi);
  if (w->saves < 16) w->save_time[w->saves] = t;
  if (++w->saves == w->fail_save) return sct_fail(err, SCT_E_LIMIT, 5, "save is full");
  return SCT_OK;
}

static sct_status see_advance(void *context, double t, sct_system **system, double *phi,
                              sct_error *err) {
  witness *w = context;
  assert_ptr_equal(*system, w->system);
  assert_non_null(phi);
  if (w->advances < 64) w->advance_time[w->advances] = t;
  if (++w->advances == w->fail_advance) return sct_fail(err, SCT_E_NOT_FINITE, 3, "field is bad");
  return SCT_OK;
}

static bool see_report(void *context, const char *phase, double fraction) {
  witness *w = context;
  assert_string_equal(phase, "march");
  if (w->reports < 64) w->report[w->reports] = fraction;
  return ++w->reports != w->cancel_at;
}

/* One march over a rod with the first eigenmode; everything optional is watched by w. */
static sct_status march_rod(witness *w, const heat *shape, const sct_march_options *o,
                            sct_march_report *report, sct_error *err) {
  double phi[POINTS];
  sct_system *s = heat_system(shape);
  w->system = s;
  for (int i = 0; i < POINTS; i++) phi[i] = sin(pi * i / (POINTS - 1));
  const sct_march_problem problem = {SCT_VARIES_LOAD, w, see_advance, see_save};
  const sct_work work = {.threads = 1, .report = see_report, .context = w};
  const sct_status status = sct_march(&s, o, &problem, &work, phi, report, err);
  heat_free(&s);
  return status;
}

static void names(void **state) {
  (void)state;
#define CHECK(symbol, text)                          \
  assert_string_equal(sct_march_name(symbol), text); \
  assert_int_equal(sct_march_find(text), symbol);
  SCT_MARCH_LIST(CHECK)
#undef CHECK
  assert_int_equal(sct_march_find("euler"), SCT_MARCH_COUNT);
  assert_null(sct_march_name(SCT_MARCH_COUNT));
}

/* What holds for every scheme and ratio: a constant stays, t is followed. With t' = w, t = 0,
 * t'' = -1 (1) of march_scheme.h reads w = implicit w + explicit w - before. */
static void weights_are_consistent(void **state) {
  (void)state;
  const double ratios[] = {0, 0.1, 0.7, 1, 1.9, 2, 2.5, 1e9};
  for (int method = 0; method < SCT_MARCH_COUNT; method++) {
    for (size_t r = 0; r < sizeof ratios / sizeof *ratios; r++) {
      const double w = ratios[r];
      const sct_march_weights v = sct_march_weigh(method, w);
      assert_near(v.now + v.before, 1, 1e-15);
      assert_near((v.implicit + v.explicit) * w - v.before, w, 1e-15 * w);
      assert_int_equal(v.before != 0, method == SCT_BDF2 && w > 0 && w <= 2);
    }
  }
}

static void stable_step(void **state) {
  (void)state;
  int64_t point = -2;
  sct_system *s = heat_system(&rod);
  assert_near(sct_march_stable_step(s, &point), 0.01, 1e-15); /* h^2 / 2 mu */
  assert_in_range(point, 1, POINTS - 2);
  assert_near(sct_march_stable_step(s, NULL), 0.01, 1e-15);
  heat_free(&s);
  s = heat_system(&(heat){POINTS, SCT_NEUMANN, SCT_ROBIN, 0.5, 0, 7, 1e9});
  assert_near(sct_march_stable_step(s, NULL), 2 / (200 + 7.0), 1e-15); /* conditions do not count */
  s->matrix->value[s->matrix->start[4] + 1] *= 3;
  assert_near(sct_march_stable_step(s, &point), 2 / (407.0 - 100 - 186 + 2 * (100 + 93)), 1e-2);
  assert_int_equal(point, s->point_of[4]);
  heat_free(&s);
  s = heat_system(&(heat){3, SCT_DIRICHLET, SCT_DIRICHLET, 0, 0, 0, 0});
  assert_true(isinf(sct_march_stable_step(s, &point)));
  assert_int_equal(point, -1);
  heat_free(&s);
}

static void forward_euler_shortens_the_last_step(void **state) {
  (void)state;
  witness w = {0};
  sct_march_report report;
  const sct_march_options o = {.method = SCT_FORWARD_EULER,
                               .start = 1,
                               .end = 1.05,
                               .step = 0.01,
                               .save = (const double[]){1, 1.025},
                               .saves = 2};
  assert_int_equal(march_rod(&w, &rod, &o, &report, NULL), SCT_OK);
  const double times[] = {1, 1.01, 1.02, 1.025, 1.035, 1.045, 1.05};
  assert_int_equal(w.advances, 7);
  for (int k = 0; k < 7; k++) assert_near(w.advance_time[k], times[k], 1e-15);
  assert_int_equal(w.saves, 3);
  assert_true(w.save_time[0] == 1 && w.save_time[1] == 1.025 && w.save_time[2] == 1.05);
  assert_int_equal(report.steps, 6);
  assert_near(report.step, 0.01, 1e-17);
  assert_near(report.stable_step, 0.01, 1e-15);
  assert_int_equal(w.reports, 7);
  for (int k = 0; k < 7; k++) assert_near(w.report[k], k / 6.0, 1e-15);
}

static void implicit_steps_are_even(void **state) {
  (void)state;
  for (int method = SCT_BACKWARD_EULER; method <= SCT_CRANK_NICOLSON; method++) {
    witness w = {0};
    sct_march_report report;
    const sct_march_options o = {.method = method,
                                 .start = 0,
                                 .end = 0.9,
                                 .step = 0.04,
                                 .save = (const double[]){0.3, 0.6, 0.9},
                                 .saves = 3};
    assert_int_equal(march_rod(&w, &rod, &o, &report, NULL), SCT_OK);
    assert_int_equal(report.steps, 24); /* 8 in each third */
    assert_near(report.step, 0.0375, 1e-16);
    assert_int_equal(report.factorisations, 1); /* though the thirds differ by rounding */
    assert_int_equal(w.saves, 3);               /* the end only once */
    assert_true(w.save_time[2] == 0.9);
    for (int k = 0; k <= 24; k++) assert_near(w.advance_time[k], 0.0375 * k, 1e-15);
    assert_string_equal(report.solve.method, "klu");
    assert_true(report.solve.residual < 1e-15);
    assert_near(report.stable_step, 0, 0);
  }
}

static void a_whole_number_of_steps_stays_whole(void **state) {
  (void)state;
  witness w = {0};
  sct_march_report report;
  const sct_march_options o = {
      .method = SCT_FORWARD_EULER, .start = 0, .end = 0.1 + 0.2, .step = 0.1};
  const heat slow = {POINTS, SCT_DIRICHLET, SCT_DIRICHLET, 0.05, 0, 0, 0};
  assert_true(o.end / o.step > 3);
  assert_int_equal(march_rod(&w, &slow, &o, &report, NULL), SCT_OK);
  assert_int_equal(report.steps, 3);
}

static void step_from_the_diffusion_number(void **state) {
  (void)state;
  for (int method = 0; method < SCT_MARCH_COUNT; method++) {
    witness w = {0};
    sct_march_report report;
    const sct_march_options o = {.method = method, .start = 0, .end = 0.1, .diffusion_number = 0.5};
    assert_int_equal(march_rod(&w, &rod, &o, &report, NULL), SCT_OK);
    assert_int_equal(report.steps, 20);
    assert_near(report.step, 0.005, 1e-15);
    assert_near(report.stable_step, 0.01, 1e-15);
  }
}

static void one_step_when_nothing_bounds_it(void **state) {
  (void)state;
  sct_system *s = heat_system(&(heat){3, SCT_DIRICHLET, SCT_DIRICHLET, 0, 0, 0, 0});
  double phi[3] = {0, 1, 0};
  sct_march_report report;
  const sct_march_options o = {
      .method = SCT_FORWARD_EULER, .start = 0, .end = 8, .diffusion_number = 1};
  s->load[0] = 0.25;
  assert_int_equal(sct_march(&s, &o, NULL, NULL, phi, &report, NULL), SCT_OK);
  assert_int_equal(report.steps, 1);
  assert_near(phi[1], 3, 1e-15);
  heat_free(&s);
}

static void a_step_beyond_the_stable_one(void **state) {
  (void)state;
  witness w = {0};
  sct_error err;
  sct_march_options o = {.method = SCT_FORWARD_EULER, .start = 0, .end = 1, .step = 0.0101};
  assert_int_equal(march_rod(&w, &rod, &o, NULL, &err), SCT_E_UNSTABLE);
  assert_in_range(err.point, 1, POINTS - 2);
  assert_non_null(strstr(err.text, "0.0101"));
  assert_non_null(strstr(err.text, "0.01 "));
  assert_int_equal(w.saves, 0);
  o.step = 0;
  o.diffusion_number = 1.01;
  assert_int_equal(march_rod(&w, &rod, &o, NULL, &err), SCT_E_UNSTABLE);
  o.diffusion_number = 1;
  assert_int_equal(march_rod(&w, &rod, &o, NULL, &err), SCT_OK);
}

/* Neumann rows that extrapolate make forward Euler unstable below the bound of the equation rows:
 * seen by growth. */
static void growth_is_seen(void **state) {
  (void)state;
  sct_error err;
  double phi[POINTS];
  sct_system *s = heat_system(&(heat){POINTS, SCT_NEUMANN, SCT_DIRICHLET, 0.5, 0, 0, 0});
  for (int64_t k = 0; k < s->matrix->start[1]; k++) {
    s->matrix->value[k] = k == 0 ? 1 : 4; /* phi_0 = -4 phi_1 */
  }
  for (int i = 0; i < POINTS; i++) phi[i] = cos(pi * i / (POINTS - 1) / 2);
  phi[POINTS - 1] = 0;
  const sct_march_options o = {
      .method = SCT_FORWARD_EULER, .start = 0, .end = 10, .diffusion_number = 1};
  assert_int_equal(sct_march(&s, &o, NULL, NULL, phi, NULL, &err), SCT_E_UNSTABLE);
  assert_in_range(err.point, 0, POINTS - 2);
  assert_non_null(strstr(err.text, "step 0.01"));
  heat_free(&s);
}

/* A matrix that feeds by wrong signs, in every scheme. */
static void growth_of_a_wrong_operator_is_seen(void **state) {
  (void)state;
  for (int method = SCT_BACKWARD_EULER; method < SCT_MARCH_COUNT; method++) {
    sct_error err;
    double phi[POINTS];
    sct_system *s = heat_system(&rod);
    for (int64_t k = 0; k < sct_csr_entries(s->matrix); k++) s->matrix->value[k] *= -1;
    for (int64_t k = 0; k < sct_csr_entries(s->coupling); k++) s->coupling->value[k] *= -1;
    for (int i = 0; i < POINTS; i++) phi[i] = sin(pi * i / (POINTS - 1));
    phi[POINTS - 1] = 0;
    const sct_march_options o = {.method = method, .start = 0, .end = 10, .step = 1e-3};
    assert_int_equal(sct_march(&s, &o, NULL, NULL, phi, NULL, &err), SCT_E_UNSTABLE);
    heat_free(&s);
  }
}

/* Everything that may grow: from zero by a source, by a flux, by a feeding reaction, by a feeding
 * Robin row, from a huge boundary value. */
static void growth_by_the_data_is_not_an_error(void **state) {
  (void)state;
  const struct {
    heat shape;
    double source, flux, wall, start, end, step, least;
  } cases[] = {
      {{POINTS, SCT_NEUMANN, SCT_NEUMANN, 1e-3, 0, 0, 0}, 1, 0, 0, 0, 1e3, 1, 999},
      {{POINTS, SCT_NEUMANN, SCT_NEUMANN, 1, 0, 0, 0}, 0, 5, 0, 0, 1e3, 1, 1e3},
      {{POINTS, SCT_NEUMANN, SCT_NEUMANN, 1, 0, 0, 0}, 0, 5, 0, 0, 1e6, 100, 1e7},
      {{POINTS, SCT_NEUMANN, SCT_NEUMANN, 1, 0, 0, 0}, 0, 1e9, 0, 1e-9, 1e3, 1, 1e9},
      {{POINTS, SCT_NEUMANN, SCT_NEUMANN, 1, 0, 0, 0}, 0, 1e12, 0, 1e-9, 1e-17, 1e-18, 0.99e-9},
      {{POINTS, SCT_NEUMANN, SCT_NEUMANN, 1, 0, -0.05, 0}, 0, 0, 0, 1e-9, 1e3, 1, 1e12},
      {{POINTS, SCT_ROBIN, SCT_NEUMANN, 0.5, 0, 0, -0.1}, 0, 0, 0, 1e-9, 1e3, 1, 1e12},
      {{POINTS, SCT_DIRICHLET, SCT_NEUMANN, 1, 0, 0, 0}, 0, 0, 1e12, 1e-12, 1e3, 1, 1e11},
  };
  for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
    for (int method = 0; method < SCT_MARCH_COUNT; method++) {
      sct_error err;
      double phi[POINTS];
      if (method == SCT_FORWARD_EULER && cases[c].end > 1e3) continue; /* millions of steps */
      sct_system *s = heat_system(&cases[c].shape);
      for (int i = 0; i < POINTS; i++) phi[i] = cases[c].start;
      for (int64_t i = 0; i < s->unknowns; i++) {
        s->load[i] = s->is_equation[i] ? cases[c].source : cases[c].flux;
      }
      if (cases[c].shape.left == SCT_DIRICHLET) phi[0] = cases[c].wall;
      sct_march_options o = {
          .method = method, .start = 0, .end = cases[c].end, .step = cases[c].step};
      if (method == SCT_FORWARD_EULER) {
        o.step = fmin(o.step, 0.9 * sct_march_stable_step(s, NULL));
      }
      if (sct_march(&s, &o, NULL, NULL, phi, NULL, &err) != SCT_OK) {
        fail_msg("case %d, %s: %s", (int)c, sct_march_name(method), err.text);
      }
      assert_true(phi[POINTS / 2] >= cases[c].least);
      heat_free(&s);
    }
  }
}

static void overflow_is_unstable(void **state) {
  (void)state;
  sct_error err;
  double phi[POINTS];
  sct_system *s = heat_system(&(heat){POINTS, SCT_NEUMANN, SCT_NEUMANN, 1, 0, -1, 0});
  for (int i = 0; i < POINTS; i++) phi[i] = 1;
  const sct_march_options o = {.method = SCT_CRANK_NICOLSON, .start = 0, .end = 1e3, .step = 0.1};
  assert_int_equal(sct_march(&s, &o, NULL, NULL, phi, NULL, &err), SCT_E_UNSTABLE);
  heat_free(&s);
}

static void too_many_steps(void **state) {
  (void)state;
  witness w = {0};
  sct_error err;
  sct_march_options o = {.method = SCT_BACKWARD_EULER,
                         .start = 0,
                         .end = 1,
                         .step = 0.1,
                         .save = (const double[]){0.55},
                         .saves = 1,
                         .max_steps = 10};
  assert_int_equal(march_rod(&w, &rod, &o, NULL, &err), SCT_E_LIMIT); /* 6 + 5 */
  assert_non_null(strstr(err.text, "11 steps"));
  assert_int_equal(w.saves + w.reports, 0);
  o.max_steps = 11;
  assert_int_equal(march_rod(&w, &rod, &o, NULL, &err), SCT_OK);
  o.max_steps = 0;
  o.step = 1e-300;
  assert_int_equal(march_rod(&w, &rod, &o, NULL, &err), SCT_E_LIMIT);
}

static void cancelled(void **state) {
  (void)state;
  for (int at = 1; at <= 3; at++) {
    witness w = {.cancel_at = at};
    sct_error err;
    sct_march_report report;
    const sct_march_options o = {.method = SCT_BDF2, .start = 0, .end = 1, .step = 0.1};
    assert_int_equal(march_rod(&w, &rod, &o, &report, &err), SCT_E_CANCELLED);
    assert_int_equal(report.steps, at - 1);
    assert_int_equal(w.saves, 0);
  }
}

static void callbacks_fail(void **state) {
  (void)state;
  sct_error err;
  const sct_march_options o = {.method = SCT_BACKWARD_EULER,
                               .start = 0,
                               .end = 1,
                               .step = 0.1,
                               .save = (const double[]){0, 0.5},
                               .saves = 2};
  for (int at = 1; at <= 3; at++) {
    witness w = {.fail_save = at};
    assert_int_equal(march_rod(&w, &rod, &o, NULL, &err), SCT_E_LIMIT);
    assert_string_equal(err.text, "save is full");
  }
  for (int at = 1; at <= 11; at += 5) {
    witness w = {.fail_advance = at};
    assert_int_equal(march_rod(&w, &rod, &o, NULL, &err), SCT_E_NOT_FINITE);
    assert_int_equal(err.point, 3);
  }
}

static void arguments(void **state) {
  (void)state;
  const sct_march_options bad[] = {
      {.method = SCT_MARCH_COUNT, .start = 0, .end = 1, .step = 0.1},
      {.method = SCT_BDF2, .start = 1, .end = 1, .step = 0.1},
      {.method = SCT_BDF2, .start = 0, .end = INFINITY, .step = 0.1},
      {.method = SCT_BDF2, .start = NAN, .end = 1, .step = 0.1},
      {.method = SCT_BDF2, .start = 0, .end = 1, .step = -0.1},
      {.method = SCT_BDF2, .start = 0, .end = 1, .step = NAN},
      {.method = SCT_BDF2, .start = 0, .end = 1},
      {.method = SCT_BDF2, .start = 0, .end = 1, .diffusion_number = -1},
      {.method = SCT_BDF2, .start = 0, .end = 1, .diffusion_number = INFINITY},
      {.method = SCT_BDF2, .start = 0, .end = 1, .step = 1, .save = (double[]){-1}, .saves = 1},
      {.method = SCT_BDF2, .start = 0, .end = 1, .step = 1, .save = (double[]){2}, .saves = 1},
      {.method = SCT_BDF2, .start = 0, .end = 1, .step = 1, .save = (double[]){NAN}, .saves = 1},
      {.method = SCT_BDF2, .start = 0, .end = 1, .step = 1, .save = (double[]){.5, .5}, .saves = 2},
      {.method = SCT_BDF2, .start = 0, .end = 1, .step = 1, .solve = {.dim = 1, .method = "magic"}},
  };
  for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
    witness w = {0};
    sct_error err = {0};
    assert_int_equal(march_rod(&w, &rod, &bad[k], NULL, &err), SCT_E_ARGUMENT);
    assert_int_equal(w.saves, 0);
    assert_true(strlen(err.text) > 10);
  }
}

static void not_finite_data(void **state) {
  (void)state;
  const sct_march_options o = {.method = SCT_FORWARD_EULER, .start = 0, .end = 1, .step = 0.001};
  for (int what = 0; what < 3; what++) {
    sct_error err;
    double phi[POINTS] = {0};
    sct_system *s = heat_system(&rod);
    if (what == 0) phi[4] = NAN;
    if (what == 1) s->load[3] = INFINITY;
    if (what == 2) s->matrix->value[s->matrix->start[3]] = NAN;
    assert_int_equal(sct_march(&s, &o, NULL, NULL, phi, NULL, &err), SCT_E_NOT_FINITE);
    assert_int_equal(err.point, 4);
    heat_free(&s);
  }
}

/* Condition rows that are singular: alone (forward Euler), or with all the others. */
static void singular_conditions(void **state) {
  (void)state;
  for (int method = 0; method < SCT_MARCH_COUNT; method++) {
    sct_error err;
    double phi[POINTS] = {0};
    sct_march_options o = {.method = method, .start = 0, .end = 1, .step = 0.01};
    sct_system *s = heat_system(&(heat){POINTS, SCT_NEUMANN, SCT_DIRICHLET, 0.5, 0, 0, 0});
    s->matrix->value[0] = 0; /* the Neumann row speaks of its neighbour only: phi_1 = 3 */
    s->load[0] = -3 * (POINTS - 1);
    const sct_status status = sct_march(&s, &o, NULL, NULL, phi, NULL, &err);
    assert_int_equal(status, method == SCT_FORWARD_EULER ? SCT_E_SINGULAR : SCT_OK);
    if (status == SCT_OK) assert_near(phi[1], 3, 1e-12);
    s->matrix->value[1] = 0;
    assert_int_equal(sct_march(&s, &o, NULL, NULL, phi, NULL, &err), SCT_E_SINGULAR);
    heat_free(&s);
  }
}

/* All points given: nothing to solve, the march still hands them out. */
static void no_unknowns(void **state) {
  (void)state;
  for (int method = 0; method < SCT_MARCH_COUNT; method++) {
    witness w = {0};
    double phi[2] = {1, 2};
    sct_march_report report;
    sct_system *s = heat_system(&(heat){2, SCT_DIRICHLET, SCT_DIRICHLET, 1, 0, 0, 0});
    const sct_march_problem problem = {0, &w, NULL, see_save};
    const sct_march_options o = {.method = method, .start = 0, .end = 1, .step = 0.25};
    assert_int_equal(sct_march(&s, &o, &problem, NULL, phi, &report, NULL), SCT_OK);
    assert_int_equal(report.steps, 4);
    assert_int_equal(w.saves, 1);
    assert_true(phi[0] == 1 && phi[1] == 2);
    heat_free(&s);
  }
}

/* A replaced matrix is checked anew: one that is stiffer is caught at its time. */
static sct_status stiffen(void *context, double t, sct_system **system, double *phi,
                          sct_error *err) {
  (void)context;
  (void)phi;
  (void)err;
  heat now = rod;
  now.mu *= 1 + t;
  heat_free(system);
  *system = heat_system(&now);
  return SCT_OK;
}

static void a_matrix_that_stiffens(void **state) {
  (void)state;
  sct_error err;
  double phi[POINTS] = {0};
  sct_march_report report;
  sct_system *s = heat_system(&rod);
  const sct_march_problem problem = {SCT_VARIES_MATRIX, NULL, stiffen, NULL};
  const sct_march_options o = {.method = SCT_FORWARD_EULER, .start = 0, .end = 1, .step = 0.008};
  assert_int_equal(sct_march(&s, &o, &problem, NULL, phi, &report, &err), SCT_E_UNSTABLE);
  assert_int_equal(report.steps, 31); /* 0.01 / (1 + t) < 0.008 from t = 0.25 */
  const sct_march_options implicit = {.method = SCT_BDF2, .start = 0, .end = 1, .step = 0.125};
  assert_int_equal(sct_march(&s, &implicit, &problem, NULL, phi, &report, &err), SCT_OK);
  assert_int_equal(report.factorisations, 8);
  heat_free(&s);
}

/* A boundary value that rises from 0 to 1e12 in a moment. */
static sct_status raise_wall(void *context, double t, sct_system **system, double *phi,
                             sct_error *err) {
  (void)context;
  (void)system;
  (void)err;
  phi[0] = t > 0.5 ? 1e12 : 0;
  return SCT_OK;
}

static void a_boundary_value_that_rises(void **state) {
  (void)state;
  for (int method = 0; method < SCT_MARCH_COUNT; method++) {
    sct_error err;
    double phi[POINTS] = {0};
    sct_system *s = heat_system(&(heat){POINTS, SCT_DIRICHLET, SCT_NEUMANN, 0.5, 0, 0, 0});
    const sct_march_problem problem = {SCT_VARIES_DIRICHLET, NULL, raise_wall, NULL};
    const sct_march_options o = {.method = method, .start = 0, .end = 2, .step = 0.01};
    assert_int_equal(sct_march(&s, &o, &problem, NULL, phi, NULL, &err), SCT_OK);
    assert_true(phi[POINTS / 2] > 1e11);
    heat_free(&s);
  }
}

/* Halfway one row loses its neighbours: zeros that stay in the pattern, or a smaller pattern. */
static sct_status cut_row(void *context, double t, sct_system **system, double *phi,
                          sct_error *err) {
  const bool *smaller = context;
  (void)phi;
  (void)err;
  heat_free(system);
  *system = heat_system(&rod);
  sct_csr *a = (*system)->matrix;
  if (t < 0.5) return SCT_OK;
  const int64_t first = a->start[4];
  a->value[first] = a->value[first + 2] = 0;
  if (!*smaller) return SCT_OK;
  const int64_t rest = sct_csr_entries(a) - (first + 3);
  a->column[first] = a->column[first + 1];
  a->value[first] = a->value[first + 1];
  memmove(a->column + first + 1, a->column + first + 3, (size_t)rest * sizeof *a->column);
  memmove(a->value + first + 1, a->value + first + 3, (size_t)rest * sizeof *a->value);
  for (int64_t i = 5; i <= a->rows; i++) a->start[i] -= 2;
  return SCT_OK;
}

static void a_pattern_that_changes(void **state) {
  (void)state;
  double phi[2][POINTS];
  for (int smaller = 0; smaller < 2; smaller++) {
    bool context = smaller;
    sct_system *s = heat_system(&rod);
    const sct_march_problem problem = {SCT_VARIES_MATRIX, &context, cut_row, NULL};
    const sct_march_options o = {
        .method = SCT_CRANK_NICOLSON, .start = 0, .end = 1, .step = 0.0625};
    for (int i = 0; i < POINTS; i++) phi[smaller][i] = i % (POINTS - 1) == 0 ? 0 : 1 + i;
    assert_int_equal(sct_march(&s, &o, &problem, NULL, phi[smaller], NULL, NULL), SCT_OK);
    heat_free(&s);
  }
  for (int i = 0; i < POINTS; i++) assert_near(phi[1][i], phi[0][i], 1e-13);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(names),
      cmocka_unit_test(weights_are_consistent),
      cmocka_unit_test(stable_step),
      cmocka_unit_test(forward_euler_shortens_the_last_step),
      cmocka_unit_test(implicit_steps_are_even),
      cmocka_unit_test(a_whole_number_of_steps_stays_whole),
      cmocka_unit_test(step_from_the_diffusion_number),
      cmocka_unit_test(one_step_when_nothing_bounds_it),
      cmocka_unit_test(a_step_beyond_the_stable_one),
      cmocka_unit_test(growth_is_seen),
      cmocka_unit_test(growth_of_a_wrong_operator_is_seen),
      cmocka_unit_test(growth_by_the_data_is_not_an_error),
      cmocka_unit_test(overflow_is_unstable),
      cmocka_unit_test(too_many_steps),
      cmocka_unit_test(cancelled),
      cmocka_unit_test(callbacks_fail),
      cmocka_unit_test(arguments),
      cmocka_unit_test(not_finite_data),
      cmocka_unit_test(singular_conditions),
      cmocka_unit_test(no_unknowns),
      cmocka_unit_test(a_matrix_that_stiffens),
      cmocka_unit_test(a_boundary_value_that_rises),
      cmocka_unit_test(a_pattern_that_changes),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
