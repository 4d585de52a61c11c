/* unit.anderson: the accelerated iteration finds the fixed point of a linear map in as many steps
 * as it has dimensions and one more, as GMRES does, and that of a map that plain steps run away
 * from. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "../near.h"
#include "anderson.h"
#include "scatter/status.h"

enum { MOST = SCT_ANDERSON_WINDOW + 4 };

/* f = b - D x, D diagonal: x = b / D */
static double residual(int64_t n, const double *d, const double *x, double *f) {
  double size = 0;
  for (int64_t k = 0; k < n; k++) {
    f[k] = 1 - d[k] * x[k];
    size = fmax(size, fabs(f[k]));
  }
  return size;
}

static int steps_to_solve(sct_anderson *a, int64_t n, const double *d, int most, double *x) {
  double f[MOST];
  int steps = 0;
  for (int64_t k = 0; k < n; k++) x[k] = 0;
  while (steps < most && residual(n, d, x, f) > 1e-10) {
    sct_anderson_step(a, f, x);
    steps++;
  }
  return steps;
}

static void takes_a_step_per_dimension(void **state) {
  (void)state;
  for (int64_t n = 1; n <= SCT_ANDERSON_WINDOW; n++) {
    double d[MOST], x[MOST];
    sct_anderson *a;
    assert_int_equal(sct_anderson_new(n, &a, NULL), SCT_OK);
    for (int64_t k = 0; k < n; k++) d[k] = 0.3 + 0.4 * (double)k; /* beyond 2 plain steps diverge */
    assert_in_range(steps_to_solve(a, n, d, MOST, x), 1, n + 1);
    for (int64_t k = 0; k < n; k++) assert_near(x[k], 1 / d[k], 1e-8);
    sct_anderson_free(&a);
  }
}

/* More dimensions than steps are remembered. */
static void a_full_window_goes_on(void **state) {
  double d[MOST], x[MOST];
  sct_anderson *a;
  (void)state;
  assert_int_equal(sct_anderson_new(MOST, &a, NULL), SCT_OK);
  for (int64_t k = 0; k < MOST; k++) d[k] = 0.2 + 0.15 * (double)k;
  assert_in_range(steps_to_solve(a, MOST, d, 60, x), 1, 59);
  for (int64_t k = 0; k < MOST; k++) assert_near(x[k], 1 / d[k], 1e-8);
  sct_anderson_free(&a);
}

static void the_first_step_is_plain_and_so_is_one_after_a_restart(void **state) {
  double x[2] = {1, 2};
  const double f[2] = {0.5, -1};
  sct_anderson *a;
  (void)state;
  assert_int_equal(sct_anderson_new(2, &a, NULL), SCT_OK);
  for (int k = 1; k <= 2; k++) {
    sct_anderson_step(a, f, x);
    assert_true(x[0] == 1 + 0.5 * k && x[1] == 2 - k);
    sct_anderson_restart(a);
  }
  sct_anderson_free(&a);
  assert_null(a);
}

/* Steps that do not change f say nothing about where it is less: the step stays plain and finite.
 */
static void steps_that_repeat_are_left_out(void **state) {
  double x[2] = {0, 0};
  const double f[2] = {1, 1};
  sct_anderson *a;
  (void)state;
  assert_int_equal(sct_anderson_new(2, &a, NULL), SCT_OK);
  for (int k = 1; k <= 3; k++) {
    sct_anderson_step(a, f, x);
    assert_true(x[0] == k && x[1] == k);
  }
  sct_anderson_free(&a);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(takes_a_step_per_dimension),
      cmocka_unit_test(a_full_window_goes_on),
      cmocka_unit_test(the_first_step_is_plain_and_so_is_one_after_a_restart),
      cmocka_unit_test(steps_that_repeat_are_left_out),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
