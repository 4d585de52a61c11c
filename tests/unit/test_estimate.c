/* The estimate of memory: what it counts with, and that it lies where peaks were measured
 * (tests/bench/memory.md). */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "asking.h"
#include "estimate.h"
#include "scatter/solve.h"

static void test_neighbours(void **state) {
  (void)state;
  static const struct {
    int dim;
    double radius;
    int count;
  } rows[] = {{1, 2.1, 4}, {2, 2.1, 12}, {3, 2.1, 32}, {1, 2, 2}, {2, 2, 8}, {3, 2, 26}, {2, 1, 0}};
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    assert_int_equal(rows[k].count, (int)estimate_neighbours(rows[k].dim, rows[k].radius));
  }
}

/* More points, more dimensions, a larger radius need more. */
static void test_order(void **state) {
  (void)state;
  sct_operator small = sct_operator_default(SCT_IPS, 2), large = small;
  large.radius = 3.1;
  for (int dim = 1; dim <= 3; dim++) {
    int64_t last = 0;
    for (int64_t n = 1; n < 2000000; n = 3 * n + 1) {
      const int64_t here = estimate_points(dim, n, &small) + estimate_factors(dim, n, &small);
      assert_true(here > last);
      assert_true(estimate_points(dim, n, &large) > estimate_points(dim, n, &small));
      assert_true(estimate_matrix(dim, n, &large) > estimate_matrix(dim, n, &small));
      assert_true(estimate_factors(dim, n, &large) >= estimate_factors(dim, n, &small));
      last = here;
    }
  }
}

/* Checks a solve on a lattice and returns its estimate. */
static double estimate(int dim, int cells, const char *operator, const char * method) {
  static const char *const corners[][2] = {{"0", "1"}, {"0,0", "1,1"}, {"0,0,0", "1,1,1"}};
  char body[1024], sides[64];
  limits most = asking_limits();
  most.points = 2000000;
  snprintf(sides, sizeof sides,
           dim == 1   ? "%d"
           : dim == 2 ? "%d,%d"
                      : "%d,%d,%d",
           cells, cells, cells);
  const int length = snprintf(
      body, sizeof body,
      "{\"inputs\":{\"cloud\":{\"lattice\":{\"lower\":[%s],\"upper\":[%s],\"cells\":[%s]}},"
      "\"operator\":%s,\"solver\":{\"method\":\"%s\"},\"diffusivity\":1,\"boundary\":[{\"on\":"
      "\"boundary\",\"type\":\"dirichlet\","
      "\"value\":0}]}}",
      corners[dim - 1][0], corners[dim - 1][1], sides, operator, method);
  const ask question = {
      .work = IPC_CHECK, .process = "solve", .body = body, .size = (size_t)length, .limits = &most};
  reply r;
  answer(&question, &r);
  assert_int_equal(200, r.status);
  free(r.bytes);
  return (double)r.memory_bytes;
}

#define LSMPS2 "{\"scheme\":\"lsmps\",\"degree\":2}"
#define LSMPS3 "{\"scheme\":\"lsmps\",\"degree\":3}"
#define MPS "{\"scheme\":\"mps\"}"

static void test_size(void **state) {
  (void)state;
  static const struct {
    int dim, cells;
    const char *operator;
    double peak; /* (MB) measured */
  } rows[] = {{1, 10000, LSMPS2, 18.2}, {1, 100000, LSMPS2, 72.9}, {1, 1000000, LSMPS2, 586.9},
              {2, 100, LSMPS2, 36.4},   {2, 100, LSMPS3, 55.3},    {2, 100, MPS, 34.1},
              {2, 300, LSMPS2, 319.7},  {2, 300, LSMPS3, 534.3},   {2, 300, MPS, 240.5},
              {2, 700, LSMPS2, 1948.7}, {2, 700, MPS, 1585.4},     {3, 15, LSMPS2, 44.9},
              {3, 15, LSMPS3, 66.1},    {3, 15, MPS, 43.5},        {3, 30, LSMPS2, 398.5},
              {3, 30, LSMPS3, 680.6},   {3, 30, MPS, 382.1},       {3, 45, LSMPS2, 2265.6},
              {3, 45, MPS, 1775.5}};
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    const double ratio =
        estimate(rows[k].dim, rows[k].cells, rows[k].operator, "direct") / 1e6 / rows[k].peak;
    printf("%d-D %7d %-32s %8.1f MB, estimate / peak %.2f\n", rows[k].dim, rows[k].cells,
           rows[k].operator, rows[k].peak, ratio);
    assert_true(ratio > 0.98 && ratio < 1.5);
  }
}

static void test_iterative(void **state) {
  (void)state;
  static const struct {
    int dim, cells;
    const char *operator;
    double peak; /* (MB) measured */
  } rows[] = {{2, 200, LSMPS2, 94.4}, {2, 350, MPS, 176.4},   {2, 700, LSMPS2, 557.9},
              {3, 20, LSMPS2, 63.2},  {3, 45, LSMPS2, 221.3}, {3, 45, MPS, 203.3},
              {3, 30, LSMPS3, 156.6}};
  if (sct_solver_load_iterative(NULL) != SCT_OK) skip();
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    const double told = estimate(rows[k].dim, rows[k].cells, rows[k].operator, "iterative") / 1e6;
    printf("%d-D %7d %-32s %8.1f MB, estimate / peak %.2f\n", rows[k].dim, rows[k].cells,
           rows[k].operator, rows[k].peak, told / rows[k].peak);
    assert_true(told > 0.95 * rows[k].peak && told < 1.5 * rows[k].peak);
  }
  const double bytes = 100; /* by which the requests may differ */
  assert_true(fabs(estimate(3, 45, LSMPS2, "auto") - estimate(3, 45, LSMPS2, "iterative")) < bytes);
  assert_true(fabs(estimate(3, 10, LSMPS2, "auto") - estimate(3, 10, LSMPS2, "direct")) < bytes);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_neighbours),
                                     cmocka_unit_test(test_order), cmocka_unit_test(test_size),
                                     cmocka_unit_test(test_iterative)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
