/* unit.kernel: every row of the table: slope against differences, bulk against single, support. */
#include <math.h>
#include <string.h>

#include "fixture.h"

static void every_kernel_is_found_by_its_name(void **state) {
  (void)state;
  assert_int_equal(sct_kernel_count(), 9);
  for (int k = 0; k < sct_kernel_count(); k++) {
    assert_ptr_equal(sct_kernel_find(sct_kernel_at(k)->name), sct_kernel_at(k));
    assert_true(strlen(sct_kernel_at(k)->source) > 0);
  }
  assert_null(sct_kernel_find("Center"));
  assert_null(sct_kernel_find(NULL));
  assert_null(sct_kernel_at(-1));
  assert_null(sct_kernel_at(sct_kernel_count()));
}

static void slope_is_the_derivative(void **state) {
  (void)state;
  const double step = 1e-5;
  for (int k = 0; k < sct_kernel_count(); k++) {
    const sct_kernel *kernel = sct_kernel_at(k);
    for (double q = 0.05; q < 0.99; q += 0.0371) {
      const double difference = (kernel->w(q + step) - kernel->w(q - step)) / (2 * step);
      if (fabs(difference - kernel->slope(q)) > 1e-6 * (1 + fabs(difference))) {
        fail_msg("%s: slope(%g) is %.12g, difference quotient %.12g", kernel->name, q,
                 kernel->slope(q), difference);
      }
    }
  }
}

static void a_weight_is_positive_falls_and_ends_at_the_support(void **state) {
  (void)state;
  for (int k = 0; k < sct_kernel_count(); k++) {
    const sct_kernel *kernel = sct_kernel_at(k);
    for (double q = 0.01; q < 0.995; q += 0.01) {
      assert_true(kernel->w(q) > 0);
      assert_true(kernel->w(q + 0.004) <= kernel->w(q));
    }
    assert_true(kernel->w(1) == 0);
    assert_true(kernel->slope(1) == 0);
    assert_true(kernel->w(1.5) == 0);
    assert_true(kernel->w(1 - 1e-9) < 3e-3);
    assert_true(kernel->singular == (kernel->w(1e-12) > 1e9));
  }
}

static void bulk_agrees_with_single(void **state) {
  (void)state;
  double q[64], w[64];
  for (int k = 0; k < 64; k++) q[k] = (k + 1) / 50.0;
  for (int k = 0; k < sct_kernel_count(); k++) {
    sct_kernel_at(k)->fill(64, q, w);
    for (int j = 0; j < 64; j++)
      assert_true(fabs(w[j] - sct_kernel_at(k)->w(q[j])) <= 1e-14 * w[j]);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_kernel_is_found_by_its_name),
      cmocka_unit_test(slope_is_the_derivative),
      cmocka_unit_test(a_weight_is_positive_falls_and_ends_at_the_support),
      cmocka_unit_test(bulk_agrees_with_single),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
