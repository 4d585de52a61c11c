/* Derivatives of expressions with respect to a parameter, against formulas. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "expression_slope.h"

enum { POINTS = 3 };

/* A task with a parameter `a`, and a cloud of three points on a line. */
typedef struct {
  task t;
  doc parameters, a;
  cloud_input cloud;
  double x[POINTS];
  int32_t order[POINTS];
} fixture;

static int set_up(void **state) {
  fixture *f = calloc(1, sizeof *f);
  f->a = (doc){.kind = DOC_NUMBER, .key = "a"};
  f->parameters = (doc){.kind = DOC_OBJECT, .child = &f->a, .count = 1};
  f->t.parameters = &f->parameters;
  f->t.work.threads = 1;
  for (int k = 0; k < POINTS; k++) f->x[k] = 0.5 * k;
  f->cloud.cloud = (sct_cloud){.dim = 1, .n = POINTS, .x = f->x};
  f->cloud.order = f->order;
  *state = f;
  return 0;
}

static int tear_down(void **state) {
  fixture *f = *state;
  language_free(&f->t.language);
  free(f);
  return 0;
}

static bool slope_of(fixture *f, const char *text, double a, double *slope) {
  expression e;
  expression_error why = {0};
  const sites on = sites_all(&f->cloud);
  f->a.number = a;
  language_free(&f->t.language);
  assert_true(expression_check(language_of(&f->t), text, 1, &e, &why));
  return expression_slope(&f->t, &e, &on, 0.25, "a", a, slope);
}

/* Largest error relative to the largest slope, or where all are zero the error itself. */
static double error_of(fixture *f, const char *text, double a, double (*exact)(double, double)) {
  double slope[POINTS], worst = 0, scale = 0;
  assert_true(slope_of(f, text, a, slope));
  for (int k = 0; k < POINTS; k++) {
    worst = fmax(worst, fabs(slope[k] - exact(f->x[k], a)));
    scale = fmax(scale, fabs(exact(f->x[k], a)));
  }
  return scale > 0 ? worst / scale : worst;
}

static double of_line(double x, double a) {
  (void)a;
  return x;
}
static double of_constant(double x, double a) {
  (void)x, (void)a;
  return 0;
}
static double of_square(double x, double a) {
  return 2 * a * x;
}
static double of_exp(double x, double a) {
  return 100 * x * exp(100 * x * a);
}
static double of_log(double x, double a) {
  (void)x;
  return 1 / (a + 1e-3);
}
static double of_wave(double x, double a) {
  return x * cos(a * x + 0.25);
}
static double of_fraction(double x, double a) {
  return -x / (a * a);
}

static void smooth_ones(void **state) {
  static const struct {
    const char *text;
    double a;
    double (*exact)(double, double);
    double tolerance;
  } rows[] = {
      {"3 + a*x", 0, of_line, 1e-14},     {"3 + a*x", 7, of_line, 1e-14},
      {"3 + a*x", 1e-9, of_line, 1e-6}, /* rounding of 3 over a step of 1e-10 */
      {"a*x", -2e-9, of_line, 1e-13},     {"x + t", 2, of_constant, 0},
      {"a^2*x", 1.5, of_square, 1e-13},   {"a^2*x", 0, of_square, 1e-13},
      {"exp(100*x*a)", 0, of_exp, 1e-10}, {"exp(100*x*a)", 0.3, of_exp, 1e-11},
      {"log(a + 1e-3)", 0, of_log, 1e-9}, {"sin(a*x + t)", 2, of_wave, 1e-12},
      {"x/a", 1e-4, of_fraction, 1e-12},  {"x/a", 40, of_fraction, 1e-12},
  };
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    const double error = error_of(*state, rows[k].text, rows[k].a, rows[k].exact);
    printf("d %-14s at a = %-6g  %.1e\n", rows[k].text, rows[k].a, error);
    if (!(error <= rows[k].tolerance)) fail_msg("%s at %g", rows[k].text, rows[k].a);
  }
}

static void none_is_told(void **state) {
  fixture *f = *state;
  double slope[POINTS];
  assert_false(slope_of(f, "sqrt(a)", 0, slope));
  assert_int_equal(f->t.error.code, SCT_E_NOT_FINITE);
  assert_int_equal(f->t.error.point, 0);
}

static void the_parameter_keeps_its_value(void **state) {
  fixture *f = *state;
  double slope[POINTS], value = 0;
  assert_true(slope_of(f, "a*x", 5, slope));
  const expression e = {.text = "a"};
  assert_true(expression_evaluate(f->t.language, &e, 1, f->x, NULL, 1, 0, &value, 1));
  assert_true(value == 5);
}

static void names_are_whole_words(void **state) {
  (void)state;
  static const struct {
    const char *text, *name;
    bool names;
  } rows[] = {{"a + b", "a", true},  {"ab + 1", "a", false}, {"1e5*x", "e5", false},
              {"2*e5", "e5", true},  {"exp(x)", "x", true},  {"tan(y)", "a", false},
              {"(a_1)", "a", false}, {"(a_1)", "a_1", true}, {"", "a", false}};
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    const expression e = {.text = rows[k].text};
    if (expression_names(&e, rows[k].name) != rows[k].names) {
      fail_msg("%s in %s", rows[k].name, rows[k].text);
    }
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(smooth_ones, set_up, tear_down),
      cmocka_unit_test_setup_teardown(none_is_told, set_up, tear_down),
      cmocka_unit_test_setup_teardown(the_parameter_keeps_its_value, set_up, tear_down),
      cmocka_unit_test(names_are_whole_words),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
