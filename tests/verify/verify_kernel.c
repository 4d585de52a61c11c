/* verify.kernel.center: the five conditions that define it ([H11] eq. 11-14, 18), and the values
 * the papers print for the others. */
#include <math.h>

#include "fixture.h"

static void close_to(double got, double needed, double tolerance) {
  if (!(fabs(got - needed) <= tolerance)) fail_msg("got %.17g, needed %.17g", got, needed);
}

/* Simpson's rule on (0, 1), exact for cubics: fine enough for quartics. */
static double integral(const sct_kernel *kernel) {
  const int steps = 2000;
  double sum = 0;
  for (int k = 0; k < steps; k++) {
    const double a = (double)k / steps, b = (k + 1.0) / steps;
    sum += (kernel->w(a) + 4 * kernel->w((a + b) / 2) + kernel->w(b)) / (6 * steps);
  }
  return sum;
}

static void center_meets_its_conditions(void **state) {
  (void)state;
  const sct_kernel *center = sct_kernel_find("center");
  close_to(center->w(1 - 1e-12), 0, 1e-13);     /* w(r_e) = 0 */
  close_to(center->slope(1 - 1e-12), 0, 1e-10); /* w'(r_e) = 0 */
  close_to(center->slope(0), 0, 0);             /* w'(0) = 0 */
  close_to(2 * integral(center), 1, 1e-12);     /* integral over (-r_e, r_e) of w / r_e = 1 */
  close_to(center->w(sqrt(0.5)), center->w(0.5) / 4, 1e-14); /* eq. 20 at r_e = 2 h */
  close_to(fabs(center->slope(0.5)), 1.876733, 5e-7);        /* numerics, section 4 */
}

static void rational_and_bell_as_printed(void **state) {
  (void)state;
  close_to(sct_kernel_find("rational")->w(0.5), 1, 1e-15);
  close_to(sct_kernel_find("rational")->w(0.25), 3, 1e-15);
  close_to(sct_kernel_find("bell")->w(0), 2, 0);
  close_to(sct_kernel_find("bell")->w(0.5), 1, 1e-15);
  close_to(sct_kernel_find("bell")->w(0.75), 0.25, 1e-15);
  close_to(sct_kernel_find("spiky")->w(0.5), 0.125, 1e-15);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(center_meets_its_conditions),
      cmocka_unit_test(rational_and_bell_as_printed),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
