/* How far a request is. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "progress.h"

typedef struct {
  int count;
  double last, residual;
  bool falls;
} listener;

static bool listen(void *context, const char *phase, double fraction) {
  listener *l = context;
  assert_non_null(phase);
  l->falls = l->falls || fraction < l->last || fraction > 1;
  l->last = fraction;
  l->count++;
  return l->count < 100;
}

static void hear(void *context, double value) {
  ((listener *)context)->residual = value;
}

static void test_phases_take_their_places(void **state) {
  (void)state;
  static const char *const phases[] = {
      "search",          "nearest neighbours", "stencil", "neighbours",
      "neighbour lists", "assemble",           "factor",  "solve",
      "encode"};
  listener l = {0};
  const ask_calls calls = {.context = &l, .report = listen, .residual = hear};
  progress p = {.calls = &calls};
  for (size_t k = 0; k < sizeof phases / sizeof *phases; k++) {
    for (double fraction = 0; fraction <= 1; fraction += 0.25) {
      assert_true(progress_report(&p, phases[k], fraction));
    }
    if (k == 0) assert_true(l.last < 0.05); /* all of a search is little of a solve */
  }
  assert_int_equal(l.count, 45);
  assert_false(l.falls);
  assert_true(l.last > 0.999);
  progress_residual(&p, 1e-3);
  assert_true(l.residual == 1e-3);
}

/* A phase that comes again, as in the steps of a march, does not take progress back; one that no
 * table knows speaks for the whole; a refusal is passed on. */
static void test_whatever_comes(void **state) {
  (void)state;
  listener l = {0};
  const ask_calls calls = {.context = &l, .report = listen};
  progress p = {.calls = &calls};
  assert_true(progress_report(&p, "row 3 of 4", 0.5));
  assert_true(l.last == 0.5);
  assert_true(progress_report(&p, "search", 0));
  assert_true(l.last == 0.5);
  progress_residual(&p, 1); /* nobody listens */
  l.count = 99;
  assert_false(progress_report(&p, "encode", 1));
}

/* Without anybody to tell, the answer is: go on. */
static void test_nobody(void **state) {
  (void)state;
  const ask_calls calls = {0};
  progress p = {.calls = &calls};
  assert_true(progress_report(&p, "solve", 0.5));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_phases_take_their_places),
      cmocka_unit_test(test_whatever_comes),
      cmocka_unit_test(test_nobody),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
