/* The time schemes alone, without the error of space: the exact solution of the system of ordinary
 * equations is known, as a decaying eigenmode of the matrix, or because the loads are made for it.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "../heat.h"
#include "../near.h"
#include "scatter/march.h"

enum { POINTS = 9 };
static const double pi = 3.14159265358979323846;

/* phi(x, t), its time derivative, and the problem it solves; matrix entries are scaled by
 * stretch(t) where the matrix varies. */
typedef struct {
  heat shape;
  int varies;
  double (*phi)(double x, double t);
  double (*rate)(double x, double t);
  sct_system *system;
  int changes; /* matrices so far */
  double checked[POINTS], error;
  int saves;
} made;

static double wave(double x, double t) {
  return sin(2 * x + 3 * t) + x * x;
}
static double wave_rate(double x, double t) {
  return 3 * cos(2 * x + 3 * t);
}
static double line(double x, double t) {
  return (1 + x * x * x) * (2 + t);
}
static double line_rate(double x, double t) {
  (void)t;
  return 1 + x * x * x;
}
static double parabola(double x, double t) {
  return cos(x) * (1 + t - 2 * t * t);
}
static double parabola_rate(double x, double t) {
  return cos(x) * (1 - 4 * t);
}

static double position(int i) {
  return (double)i / (POINTS - 1);
}

/* Loads for which phi(x, t) is the exact solution: phi' + A phi, or the condition's left side. */
static void make_load(made *p, double t) {
  sct_system *s = p->system;
  double phi[POINTS], y[POINTS], left[POINTS];
  for (int i = 0; i < POINTS; i++) phi[i] = p->phi(position(i), t);
  for (int64_t i = 0; i < s->unknowns; i++) y[i] = phi[s->point_of[i]];
  sct_csr_multiply(s->matrix, y, left);
  sct_csr_multiply_add(s->coupling, 1, phi, left);
  for (int64_t i = 0; i < s->unknowns; i++) {
    s->load[i] = left[i] + (s->is_equation[i] ? p->rate(position(s->point_of[i]), t) : 0);
  }
}

static sct_status advance(void *context, double t, sct_system **system, double *phi,
                          sct_error *err) {
  made *p = context;
  (void)err;
  if (p->varies & SCT_VARIES_MATRIX) {
    heat now = p->shape;
    now.mu *= 1 + 0.5 * sin(5 * t);
    now.reaction += 2 * t;
    heat_free(&p->system);
    p->system = heat_system(&now);
    p->changes++;
  }
  make_load(p, t);
  for (int i = 0; i < POINTS; i++) {
    if (p->system->row_of[i] < 0) phi[i] = p->phi(position(i), t);
  }
  *system = p->system;
  return SCT_OK;
}

static sct_status compare(void *context, double t, const double *phi, sct_error *err) {
  made *p = context;
  (void)err;
  p->saves++;
  for (int i = 0; i < POINTS; i++) {
    p->error = fmax(p->error, fabs(phi[i] - p->phi(position(i), t)));
  }
  return SCT_OK;
}

/* Largest error over the save times. */
static double error_of(made *p, sct_march_options o) {
  sct_error err = {0};
  double phi[POINTS];
  const sct_march_problem problem = {p->varies, p, advance, compare};
  p->system = heat_system(&p->shape);
  p->error = 0;
  for (int i = 0; i < POINTS; i++) phi[i] = p->phi(position(i), o.start);
  sct_march_report report;
  if (sct_march(&p->system, &o, &problem, NULL, phi, &report, &err) != SCT_OK) {
    fail_msg("%s: %s", sct_march_name(o.method), err.text);
  }
  assert_true(report.steps > 0);
  heat_free(&p->system);
  return p->error;
}

static const struct {
  sct_march_method method;
  double step, order;
} schemes[] = {{SCT_FORWARD_EULER, 1. / 400, 1},
               {SCT_BACKWARD_EULER, 1. / 64, 1},
               {SCT_CRANK_NICOLSON, 1. / 64, 2},
               {SCT_BDF2, 1. / 64, 2}};

/* The error falls by 2^order from step to step / 2, twice. */
static void expect_orders(made *p) {
  for (size_t s = 0; s < sizeof schemes / sizeof *schemes; s++) {
    double errors[3];
    for (int r = 0; r < 3; r++) {
      const sct_march_options o = {.method = schemes[s].method,
                                   .start = 0.25,
                                   .end = 1,
                                   .step = schemes[s].step / (1 << r),
                                   .save = (const double[]){0.7},
                                   .saves = 1,
                                   .solve = {.dim = 1, .method = "auto"}};
      errors[r] = error_of(p, o);
    }
    for (int r = 0; r < 2; r++) {
      const double order = log2(errors[r] / errors[r + 1]);
      printf("%-15s error %.2e order %.3f\n", sct_march_name(schemes[s].method), errors[r + 1],
             order);
      assert_near(order, schemes[s].order, 0.12);
    }
  }
}

static void order_with_time_dependent_dirichlet(void **state) {
  (void)state;
  made p = {.shape = {POINTS, SCT_DIRICHLET, SCT_DIRICHLET, 0.8, 1, 0.5, 0},
            .varies = SCT_VARIES_LOAD | SCT_VARIES_DIRICHLET,
            .phi = wave,
            .rate = wave_rate};
  expect_orders(&p);
}

static void order_with_neumann_and_robin(void **state) {
  (void)state;
  made p = {.shape = {POINTS, SCT_NEUMANN, SCT_ROBIN, 0.8, 1, 0.5, 2},
            .varies = SCT_VARIES_LOAD,
            .phi = wave,
            .rate = wave_rate};
  expect_orders(&p);
}

static void order_with_time_dependent_matrix(void **state) {
  (void)state;
  made p = {.shape = {POINTS, SCT_DIRICHLET, SCT_ROBIN, 0.5, 1, 0.5, 2},
            .varies = SCT_VARIES_MATRIX | SCT_VARIES_LOAD | SCT_VARIES_DIRICHLET,
            .phi = wave,
            .rate = wave_rate};
  expect_orders(&p);
  assert_true(p.changes > 0);
}

/* Polynomials of the degree of the scheme are exact, whatever the steps: the save times divide the
 * interval badly, with ratios that restart BDF2. */
static void exact_for_polynomials(void **state) {
  (void)state;
  const double save[] = {0.25, 0.3, 0.5078125, 0.51, 0.9};
  for (size_t s = 0; s < sizeof schemes / sizeof *schemes; s++) {
    const bool second = schemes[s].method == SCT_CRANK_NICOLSON;
    made p = {.shape = {POINTS, SCT_DIRICHLET, SCT_ROBIN, 0.5, 1, 0.5, 2},
              .varies = SCT_VARIES_MATRIX | SCT_VARIES_LOAD | SCT_VARIES_DIRICHLET,
              .phi = second ? parabola : line,
              .rate = second ? parabola_rate : line_rate};
    const sct_march_options o = {.method = schemes[s].method,
                                 .start = 0.25,
                                 .end = 1,
                                 .step = schemes[s].step * 1.1,
                                 .save = save,
                                 .saves = 5};
    assert_near(error_of(&p, o), 0, 2e-13);
    assert_int_equal(p.saves, 6);
  }
}

/* BDF2 keeps its order when steps change: each save interval has its own. */
static void bdf2_order_with_uneven_steps(void **state) {
  (void)state;
  double errors[3];
  const double save[] = {0.1, 0.13, 0.3, 0.37, 0.5, 0.85, 0.9};
  for (int r = 0; r < 3; r++) {
    made p = {.shape = {POINTS, SCT_DIRICHLET, SCT_NEUMANN, 0.5, 0, 0, 0},
              .varies = SCT_VARIES_LOAD | SCT_VARIES_DIRICHLET,
              .phi = wave,
              .rate = wave_rate};
    errors[r] = error_of(&p, (sct_march_options){.method = SCT_BDF2,
                                                 .start = 0,
                                                 .end = 1,
                                                 .step = 0.02 / (1 << r),
                                                 .save = save,
                                                 .saves = 7});
  }
  assert_near(log2(errors[0] / errors[1]), 2, 0.25);
  assert_near(log2(errors[1] / errors[2]), 2, 0.25);
}

/* Nothing varies: sin(k pi x) decays by the scheme's own factor of lambda dt, to rounding. */
static void eigenmodes_decay_by_the_schemes_factor(void **state) {
  (void)state;
  const heat shape = {POINTS, SCT_DIRICHLET, SCT_DIRICHLET, 0.1, 0, 0.3, 0};
  const double h = 1.0 / (POINTS - 1), dt = 0.0625;
  for (int mode = 1; mode < POINTS - 1; mode++) {
    const double z = dt * (0.4 / (h * h) * pow(sin(mode * pi * h / 2), 2) + shape.reaction);
    const double factors[] = {1 - z, 1 / (1 + z), (1 - z / 2) / (1 + z / 2)};
    for (int method = 0; method < 3; method++) {
      double phi[POINTS];
      sct_system *s = heat_system(&shape);
      const sct_march_options o = {.method = method,
                                   .start = 0,
                                   .end = 4 * dt,
                                   .step = dt,
                                   .solve = {.dim = 1, .method = "umfpack"}};
      for (int i = 0; i < POINTS; i++) phi[i] = sin(mode * pi * position(i));
      phi[0] = phi[POINTS - 1] = 0;
      sct_march_report report;
      assert_int_equal(sct_march(&s, &o, NULL, NULL, phi, &report, NULL), SCT_OK);
      assert_int_equal(report.steps, 4);
      assert_int_equal(report.factorisations, method == SCT_FORWARD_EULER ? 0 : 1);
      for (int i = 0; i < POINTS; i++) {
        assert_near(phi[i], pow(factors[method], 4) * sin(mode * pi * position(i)), 1e-13);
      }
      heat_free(&s);
    }
  }
}

/* Order against the exact exponential, where nothing varies and no callback is given. */
static void eigenmode_order(void **state) {
  (void)state;
  const heat shape = {POINTS, SCT_DIRICHLET, SCT_DIRICHLET, 0.1, 0, 0.3, 0};
  const double h = 1.0 / (POINTS - 1);
  const double lambda = 0.4 / (h * h) * pow(sin(pi * h / 2), 2) + shape.reaction;
  for (size_t k = 0; k < sizeof schemes / sizeof *schemes; k++) {
    double errors[2];
    for (int r = 0; r < 2; r++) {
      double phi[POINTS];
      sct_system *s = heat_system(&shape);
      const sct_march_options o = {
          .method = schemes[k].method, .start = 0, .end = 1, .step = 0.02 / (1 << r)};
      for (int i = 0; i < POINTS; i++) phi[i] = sin(pi * position(i));
      phi[POINTS - 1] = 0;
      assert_int_equal(sct_march(&s, &o, NULL, NULL, phi, NULL, NULL), SCT_OK);
      errors[r] = fabs(phi[POINTS / 2] - exp(-lambda));
      heat_free(&s);
    }
    assert_near(log2(errors[0] / errors[1]), schemes[k].order, 0.1);
  }
}

/* A flux switched on at t = 0 over values that know nothing of it: no scheme may lose a part of
 * the first step, so the second-order ones stay ahead. Balance: n flux dt per step. */
static void flux_from_the_start(void **state) {
  (void)state;
  for (size_t k = 0; k < sizeof schemes / sizeof *schemes; k++) {
    sct_system *s = heat_system(&(heat){POINTS, SCT_NEUMANN, SCT_NEUMANN, 1, 0, 0, 0});
    double phi[POINTS] = {0}, sum = 0;
    const double flux = 3, h = 1.0 / (POINTS - 1);
    s->load[0] = flux;
    const sct_march_options o = {
        .method = schemes[k].method, .start = 0, .end = 0.5, .step = schemes[k].step};
    assert_int_equal(sct_march(&s, &o, NULL, NULL, phi, NULL, NULL), SCT_OK);
    for (int i = 1; i < POINTS - 1; i++) sum += h * phi[i];
    assert_near(sum, flux * 0.5, 1e-12); /* every scheme integrates the constant flux exactly */
    assert_near(phi[0] - phi[1], flux * h, 1e-13);
    assert_near(phi[POINTS - 1], phi[POINTS - 2], 1e-13);
    heat_free(&s);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(order_with_time_dependent_dirichlet),
      cmocka_unit_test(order_with_neumann_and_robin),
      cmocka_unit_test(order_with_time_dependent_matrix),
      cmocka_unit_test(exact_for_polynomials),
      cmocka_unit_test(bdf2_order_with_uneven_steps),
      cmocka_unit_test(eigenmodes_decay_by_the_schemes_factor),
      cmocka_unit_test(eigenmode_order),
      cmocka_unit_test(flux_from_the_start),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
