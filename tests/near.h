/* near.h - doubles compared as doubles (cmocka's assert_float_equal compares floats). Include
 * cmocka.h before. */
#ifndef TESTS_NEAR_H
#define TESTS_NEAR_H

#include <math.h>

static inline void near_at(double got, double expected, double tolerance, const char *what,
                           const char *file, int line) {
  if (fabs(got - expected) <= tolerance) return;
  print_error("%s = %.17g, expected %.17g within %.1e, off by %.2e\n", what, got, expected,
              tolerance, fabs(got - expected));
  _fail(file, line);
}

/* |got - expected| <= tolerance; false for a NaN. */
#define assert_near(got, expected, tolerance) \
  near_at(got, expected, tolerance, #got, __FILE__, __LINE__)

#endif
