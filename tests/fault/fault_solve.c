/* Every allocation of a solve and of a march fails once, those of the packages too: the answer is
 * SCT_E_MEMORY (or, where a package knows a way round, the right result) and nothing leaks, but for
 * hypre. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>
#include <suitesparse/SuiteSparse_config.h>

#include "../heat.h"
#include "../near.h"
#include "scarce.h"
#include "scatter/march.h"

enum { POINTS = 40 };

/* hypre, behind PETSc, cannot let go of a multigrid that PETSc could not finish. */
const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void) {
  return "leak:hypre_\n";
}

static int packages_fail_too(void **state) {
  (void)state;
  SuiteSparse_config.malloc_func = malloc;
  SuiteSparse_config.calloc_func = calloc;
  SuiteSparse_config.realloc_func = realloc;
  return 0;
}

typedef struct {
  sct_system *system;
  const char *method;
  sct_march_method scheme;
  double x[POINTS]; /* solution */
} scenario;

static sct_status solve(scenario *s, sct_error *err) {
  const sct_csr *a = s->system->matrix;
  const sct_solve_options options = {.dim = 2, .method = s->method};
  sct_solver *solver = (sct_solver *)s;
  double b[POINTS];
  for (int i = 0; i < POINTS; i++) b[i] = 1;
  sct_status status = sct_solver_analyse(a, &options, &solver, err);
  if (status != SCT_OK) {
    assert_null(solver);
    return status;
  }
  status = sct_solver_factor(solver, a, err);
  if (status == SCT_OK) status = sct_solver_factor(solver, a, err);
  if (status == SCT_OK) status = sct_solver_solve(solver, b, false, s->x, err);
  if (status == SCT_E_MEMORY) {
    assert_int_not_equal(sct_solver_solve(solver, b, false, s->x, NULL), SCT_OK);
    assert_int_equal(sct_solver_factor(solver, a, NULL), SCT_OK); /* as good as new */
    assert_int_equal(sct_solver_solve(solver, b, false, s->x, NULL), SCT_OK);
  }
  sct_solver_free(&solver);
  return status;
}

static sct_status march(scenario *s, sct_error *err) {
  const double save[] = {0.5};
  const sct_march_options options = {.method = s->scheme,
                                     .start = 0,
                                     .end = 1,
                                     .step = 1,
                                     .diffusion_number = 0.5,
                                     .save = save,
                                     .saves = 1,
                                     .solve = {.dim = 1, .method = s->method}};
  memset(s->x, 0, sizeof s->x);
  s->x[0] = 1;
  return sct_march(&s->system, &options, NULL, NULL, s->x, NULL, err);
}

/* Runs until no allocation is left to fail; the result is that of the run without failure. */
static void fail_each(sct_status (*run)(scenario *, sct_error *), scenario *s) {
  double expected[POINTS];
  int failures = 0;
  assert_int_equal(run(s, NULL), SCT_OK);
  memcpy(expected, s->x, sizeof expected);
  for (int64_t n = 0;; n++) {
    sct_error err = {0};
    scarce_after(n, false);
    const sct_status status = run(s, &err);
    const bool hit = scarce_end();
    if (status == SCT_OK) {
      for (int64_t i = 0; i < s->system->n; i++) assert_near(s->x[i], expected[i], 1e-9);
    } else {
      assert_int_equal(status, SCT_E_MEMORY);
      assert_int_equal(err.code, SCT_E_MEMORY);
      assert_true(strlen(err.text) > 10);
      failures++;
    }
    if (!hit) break;
  }
  assert_in_range(failures, 10, 1000);
}

/* Solver k of the table, the iterative one only where it is there. */
static const char *solver_name(int k) {
  const char *name = sct_solver_name(k);
  const bool iterates = name != NULL && strcmp(name, "iterative") == 0;
  return iterates && sct_solver_load_iterative(NULL) != SCT_OK ? NULL : name;
}

static void solving(void **state) {
  (void)state;
  for (int k = 0; solver_name(k) != NULL; k++) {
    scenario s = {.method = solver_name(k)};
    s.system = heat_system(&(heat){POINTS, SCT_ROBIN, SCT_ROBIN, 0.1, 1, 1, 2});
    fail_each(solve, &s);
    heat_free(&s.system);
  }
}

static void marching(void **state) {
  (void)state;
  for (int k = 0; solver_name(k) != NULL; k++) {
    for (int scheme = 0; scheme < SCT_MARCH_COUNT; scheme++) {
      scenario s = {.method = solver_name(k), .scheme = scheme};
      s.system = heat_system(&(heat){POINTS, SCT_DIRICHLET, SCT_NEUMANN, 1e-4, 0, 0, 0});
      fail_each(march, &s);
      heat_free(&s.system);
    }
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup(solving, packages_fail_too),
      cmocka_unit_test_setup(marching, packages_fail_too),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
