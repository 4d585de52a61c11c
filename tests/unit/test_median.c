#include <inttypes.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "clouds.h"
#include "scatter/search.h"

static int ascending(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static void check(const double *value, int64_t n) {
  double *copy = malloc((size_t)n * sizeof *copy), median = NAN;
  memcpy(copy, value, (size_t)n * sizeof *copy);
  assert_int_equal(sct_median(value, n, &median, NULL), SCT_OK);
  assert_memory_equal(copy, value, (size_t)n * sizeof *copy);
  qsort(copy, (size_t)n, sizeof *copy, ascending);
  const double low = copy[(n - 1) / 2], high = copy[n / 2];
  assert_true(median == (low == high ? low : low / 2 + high / 2));
  free(copy);
}

static void is_the_middle(void **state) {
  (void)state;
  const uint64_t seed = 47;
  uint64_t stream = seed;
  double value[300];
  print_message("seed %" PRIu64 "\n", seed);
  for (int64_t n = 1; n <= 300; n++) {
    for (int64_t i = 0; i < n; i++) {
      double u = cloud_random(&stream);
      value[i] = n % 3 == 0 ? u - 0.5 : n % 3 == 1 ? floor(4 * u) : pow(10, 600 * u - 300);
    }
    check(value, n);
  }
}

static void extremes(void **state) {
  (void)state;
  check((double[]){INFINITY, 1, INFINITY}, 3);
  check((double[]){-INFINITY, 5e-324, -5e-324, 1e308}, 4);
  check((double[]){7, 7, 7, 7}, 4);
  check((double[]){1e308, 1.5e308}, 2);
  check((double[]){3, 1, 2, 2, 2, 9}, 6);
  double median;
  sct_error err;
  assert_int_equal(sct_median(&median, 0, &median, &err), SCT_E_ARGUMENT);
  assert_int_equal(sct_median(NULL, -1, &median, NULL), SCT_E_ARGUMENT);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(is_the_middle),
      cmocka_unit_test(extremes),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
