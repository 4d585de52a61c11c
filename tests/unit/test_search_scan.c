/* The distance test in all its forms. */
#include <inttypes.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "clouds.h"
#include "search_scan.h"

static double square_of(const sct_scan *s, const double *x, int64_t j) {
  double sum = 0;
  for (int k = 0; k < s->dim; k++) sum += (s->x[k][j] - x[k]) * (s->x[k][j] - x[k]);
  return sum;
}

/* One question, answered by the form that `wide` says and here. */
static void ask(sct_scan *s, bool wide, const double *x, double square, int32_t self) {
  static int32_t hit[SCT_SCAN_MOST + SCT_SCAN_PAD];
  int64_t m = 0;
  double closest = INFINITY;
  s->wide = s->wide && wide;
  int64_t n = sct_scan_hits(s, x, square, self, hit);
  for (int64_t j = 0; j < s->n; j++) {
    if (s->point[j] == self) continue;
    double d = square_of(s, x, j);
    if (d < closest) closest = d;
    if (!(d < square)) continue;
    assert_true(m < n);
    assert_int_equal(hit[m++], s->point[j]);
  }
  assert_int_equal(m, n);
  assert_true(sct_scan_closest(s, x, self) == closest);
}

static void every_form(void **state) {
  (void)state;
  static sct_scan s;
  const uint64_t seed = 41;
  uint64_t stream = seed;
  print_message("seed %" PRIu64 "\n", seed);
  for (int round = 0; round < 6000; round++) {
    sct_scan_init(&s, 1 + round % 3);
    if (round == 0) print_message("wide: %s\n", s.wide ? "yes" : "no");
    s.n = round < 100 ? round : (int64_t)(cloud_random(&stream) * 90);
    for (int64_t j = 0; j < s.n; j++) {
      for (int k = 0; k < s.dim; k++) s.x[k][j] = cloud_random(&stream);
      s.point[j] = (int32_t)(1000 - 7 * j);
    }
    sct_scan_close(&s);
    const double x[] = {cloud_random(&stream), cloud_random(&stream), cloud_random(&stream)};
    int32_t self = s.n > 0 ? s.point[s.n / 2] : 5;
    double square = round % 4 == 0 ? 0 : round % 4 == 1 ? INFINITY : cloud_random(&stream);
    if (round % 7 == 0 && s.n > 0) square = square_of(&s, x, 0); /* a tie */
    ask(&s, true, x, square, self);
    ask(&s, false, x, square, self);
    ask(&s, false, x, square, -1);
  }
}

static void full_scan(void **state) {
  (void)state;
  static sct_scan s;
  uint64_t stream = 43;
  sct_scan_init(&s, 3);
  s.n = SCT_SCAN_MOST;
  for (int64_t j = 0; j < s.n; j++) {
    for (int k = 0; k < 3; k++) s.x[k][j] = cloud_random(&stream);
    s.point[j] = (int32_t)j;
  }
  sct_scan_close(&s);
  ask(&s, true, (double[]){0.5, 0.5, 0.5}, INFINITY, SCT_SCAN_MOST - 1);
  ask(&s, false, (double[]){0.5, 0.5, 0.5}, 0.1, 0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_form),
      cmocka_unit_test(full_scan),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
