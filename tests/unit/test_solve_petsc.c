/* The iterative row of the table: tolerance, limits, history, fallback; what the policy sees. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "../dense.h"
#include "../near.h"
#include "../seed.h"
#include "scatter/solve.h"
#include "solve_policy.h"

enum { SIDE = 40, N = SIDE * SIDE };

typedef struct {
  sct_csr *a;
  double b[N], x[N];
} problem;

/* Five points of -lap u + v u_x + shift u by upwind differences, on a square. */
static void make(problem *p, double v, double shift) {
  sct_error err;
  int64_t entries = 0;
  assert_int_equal(sct_csr_new(N, N, 5 * N, &p->a, &err), SCT_OK);
  for (int i = 0; i < N; i++) {
    const int offset[] = {-SIDE, -1, 0, 1, SIDE};
    const double value[] = {-1, -1 - v, 4 + v + shift, -1, -1};
    const bool in[] = {i >= SIDE, i % SIDE > 0, true, i % SIDE < SIDE - 1, i < N - SIDE};
    for (int k = 0; k < 5; k++) {
      if (!in[k]) continue;
      p->a->column[entries] = i + offset[k];
      p->a->value[entries++] = value[k];
    }
    p->a->start[i + 1] = entries;
    p->b[i] = 1 + i % 7;
  }
}

static double relative_residual(const problem *p) {
  double r[N], square = 0, size = 0;
  sct_csr_residual(p->a, p->x, p->b, r, NULL);
  for (int i = 0; i < N; i++) {
    square += r[i] * r[i];
    size += p->b[i] * p->b[i];
  }
  return sqrt(square / size);
}

static sct_solver *ready(problem *p, const sct_solve_options *options) {
  sct_solver *solver = NULL;
  sct_error err = {0};
  if (sct_solver_analyse(p->a, options, &solver, &err) != SCT_OK) fail_msg("%s", err.text);
  if (sct_solver_factor(solver, p->a, &err) != SCT_OK) fail_msg("%s", err.text);
  return solver;
}

static void meets_the_tolerance(void **state) {
  (void)state;
  static problem p;
  const double speeds[] = {0, 1, 100}, tolerances[] = {1e-4, 1e-10, 1e-13};
  const char *const preconditioners[] = {"ilu", "amg", NULL};
  for (int k = 0; k < 27; k++) {
    const sct_solve_options options = {.dim = 2,
                                       .method = "iterative",
                                       .tolerance = tolerances[k % 3],
                                       .preconditioner = preconditioners[k / 3 % 3]};
    sct_error err = {0};
    make(&p, speeds[k / 9], 0);
    sct_solver *solver = ready(&p, &options);
    if (sct_solver_solve(solver, p.b, false, p.x, &err) != SCT_OK) fail_msg("%s", err.text);
    const sct_solve_report *r = sct_solver_report(solver);
    assert_string_equal(r->method, "iterative");
    assert_string_equal(r->fallback, "");
    assert_string_equal(r->krylov, "bicgstab");
    if (options.preconditioner != NULL)
      assert_string_equal(r->preconditioner, options.preconditioner);
    assert_true(r->iterations > 0 && r->iterations < 200);
    assert_true(r->relative_residual <= options.tolerance);
    assert_true(relative_residual(&p) <= 1.01 * options.tolerance); /* rows here are scaled alike */
    assert_true(r->history_count > 1 && r->history_count <= SCT_SOLVE_HISTORY);
    assert_near(r->history[0], 1, 1e-12);
    assert_true(r->reciprocal_condition == 0);
    assert_int_equal(r->peak_bytes > 0, strcmp(r->preconditioner, "ilu") == 0);
    sct_solver_free(&solver);
    sct_csr_free(&p.a);
  }
}

/* The direct solution, whatever became of the iterative one. */
static void expect_fallback(problem *p, const sct_solve_options *options, int most) {
  sct_error err = {0};
  sct_solver *solver = ready(p, options);
  if (sct_solver_solve(solver, p->b, false, p->x, &err) != SCT_OK) fail_msg("%s", err.text);
  const sct_solve_report *r = sct_solver_report(solver);
  assert_string_equal(r->method, "umfpack");
  assert_true(strlen(r->fallback) > 20);
  assert_true(r->residual < 1e-14 && r->reciprocal_condition > 0);
  assert_true(r->history_count <= most + 1);
  assert_int_equal(sct_solver_solve(solver, p->b, false, p->x, &err), SCT_OK); /* and goes on */
  assert_true(relative_residual(p) < 1e-12);
  sct_solver_free(&solver);
}

static void iterations_are_limited(void **state) {
  (void)state;
  static problem p;
  for (int most = 1; most < 12; most += 5) {
    const sct_solve_options options = {
        .dim = 2, .method = "iterative", .max_iterations = most, .preconditioner = "ilu"};
    make(&p, 0, 0);
    expect_fallback(&p, &options, most);
    sct_csr_free(&p.a);
  }
}

static void unreachable_tolerance_falls_back(void **state) {
  (void)state;
  static problem p;
  const sct_solve_options options = {.dim = 2, .method = "iterative", .tolerance = 1e-30};
  make(&p, 0, 0);
  expect_fallback(&p, &options, 1000);
  sct_csr_free(&p.a);
}

/* A permutation has no diagonal for incomplete factors or smoothers to divide by. */
static void no_preconditioner_falls_back(void **state) {
  (void)state;
  static problem p;
  sct_error err;
  const sct_solve_options options = {.dim = 2, .method = "iterative"};
  assert_int_equal(sct_csr_new(N, N, N, &p.a, &err), SCT_OK);
  for (int i = 0; i < N; i++) {
    p.a->column[i] = (i + 1) % N;
    p.a->value[i] = 1 + i % 3;
    p.a->start[i + 1] = i + 1;
    p.b[i] = 1;
  }
  expect_fallback(&p, &options, 1000);
  sct_csr_free(&p.a);
}

/* Where a direct solver would be too slow the failure is told. */
static void too_large_to_fall_back(void **state) {
  (void)state;
  assert_true(sct_solve_suits_fallback(200000, 3));
  assert_false(sct_solve_suits_fallback(200001, 3));
  assert_true(sct_solve_suits_fallback(200001, 2));
}

static void a_guess_saves_iterations(void **state) {
  (void)state;
  static problem p;
  const sct_solve_options options = {.dim = 2, .method = "iterative", .guess = true};
  make(&p, 0, 0);
  sct_solver *solver = ready(&p, &options);
  memset(p.x, 0, sizeof p.x);
  assert_int_equal(sct_solver_solve(solver, p.b, false, p.x, NULL), SCT_OK);
  assert_true(sct_solver_report(solver)->iterations > 1);
  assert_int_equal(sct_solver_solve(solver, p.b, false, p.x, NULL), SCT_OK);
  assert_int_equal(sct_solver_report(solver)->iterations, 0);
  p.x[3] = NAN; /* no guess */
  assert_int_equal(sct_solver_solve(solver, p.b, false, p.x, NULL), SCT_OK);
  assert_true(relative_residual(&p) < 1e-9);
  memset(p.b, 0, sizeof p.b);
  assert_int_equal(sct_solver_solve(solver, p.b, false, p.x, NULL), SCT_OK);
  for (int i = 0; i < N; i++) assert_true(p.x[i] == 0);
  sct_solver_free(&solver);
  sct_csr_free(&p.a);
}

/* Transposed systems are iterated, with ILU in the place of multigrid. */
static void transposed(void **state) {
  (void)state;
  static problem p;
  static const char *const preconditioners[] = {"ilu", "amg"};
  double r[N];
  for (int k = 0; k < 2; k++) {
    const sct_solve_options options = {
        .dim = 2, .method = "iterative", .preconditioner = preconditioners[k]};
    make(&p, 3, 0);
    sct_solver *solver = ready(&p, &options);
    assert_int_equal(sct_solver_solve(solver, p.b, true, p.x, NULL), SCT_OK);
    assert_string_equal(sct_solver_report(solver)->fallback, "");
    assert_string_equal(sct_solver_report(solver)->preconditioner, "ilu");
    assert_true(sct_solver_report(solver)->iterations > 0);
    sct_csr_residual_transposed(p.a, p.x, p.b, r, NULL);
    for (int i = 0; i < N; i++) assert_near(r[i], 0, 1e-8);
    sct_solver_free(&solver);
    sct_csr_free(&p.a);
  }
}

typedef struct {
  int residuals, reports, most; /* how often it may be told of progress */
  double last, fraction;
} listener;

static void hear(void *context, double value) {
  listener *l = context;
  l->residuals++;
  l->last = value;
}

static bool let(void *context, const char *phase, double fraction) {
  listener *l = context;
  assert_string_equal(phase, "solve");
  assert_true(fraction >= 0 && fraction <= 1);
  l->fraction = fraction;
  return ++l->reports <= l->most;
}

/* Every iteration is told, and may be the last: then nobody takes over. */
static void is_watched(void **state) {
  (void)state;
  static problem p;
  listener l = {.most = 1000};
  const sct_work work = {.report = let, .context = &l, .residual = hear};
  const sct_solve_options options = {
      .dim = 2, .method = "iterative", .tolerance = 1e-9, .work = &work};
  make(&p, 3, 0);
  sct_solver *solver = ready(&p, &options);
  assert_int_equal(sct_solver_solve(solver, p.b, false, p.x, NULL), SCT_OK);
  const sct_solve_report *report = sct_solver_report(solver);
  assert_int_equal(l.residuals, report->iterations + 1);
  assert_near(l.last, report->relative_residual, 1e-10);
  assert_true(l.fraction == 1);

  l = (listener){.most = 1};
  assert_int_equal(sct_solver_solve(solver, p.b, false, p.x, NULL), SCT_E_CANCELLED);
  assert_string_equal(report->fallback, "");
  assert_int_equal(l.reports, 2);
  sct_solver_free(&solver);
  sct_csr_free(&p.a);
}

static void is_foreseen(void **state) {
  (void)state;
  const sct_solve_options plane = {.dim = 2}, space = {.dim = 3},
                          direct = {.dim = 3, .method = "direct"};
  const sct_solve_options iterative = {.dim = 1, .method = "iterative"};
  assert_false(sct_solver_iterates(NULL, 1000000));
  assert_false(sct_solver_iterates(&plane, 99999)); /* it depends */
  assert_true(sct_solver_iterates(&plane, 100000));
  assert_true(sct_solver_iterates(&space, 3000));
  assert_false(sct_solver_iterates(&direct, 1000000));
  assert_true(sct_solver_iterates(&iterative, 1));
}

static void factored_anew(void **state) {
  (void)state;
  static problem p;
  const sct_solve_options options = {.dim = 2, .method = "iterative"};
  make(&p, 0, 0);
  sct_solver *solver = ready(&p, &options);
  for (int round = 0; round < 3; round++) {
    for (int64_t k = 0; k < sct_csr_entries(p.a); k++) p.a->value[k] *= 1.5;
    assert_int_equal(sct_solver_factor(solver, p.a, NULL), SCT_OK);
    assert_int_equal(sct_solver_solve(solver, p.b, false, p.x, NULL), SCT_OK);
    assert_true(relative_residual(&p) < 1.01e-10);
  }
  p.a->value[0] = NAN;
  assert_int_equal(sct_solver_factor(solver, p.a, NULL), SCT_E_NOT_FINITE);
  assert_int_equal(sct_solver_solve(solver, p.b, false, p.x, NULL), SCT_E_ARGUMENT);
  sct_solver_free(&solver);
  sct_csr_free(&p.a);
}

static void traits(void **state) {
  (void)state;
  static problem p;
  const struct {
    double v, shift;
    bool dominated;
  } rows[] = {{0, 0, false}, {0, 10, true}, {1000, 0, false}};
  for (int k = 0; k < 3; k++) {
    make(&p, rows[k].v, rows[k].shift);
    const sct_solve_traits t = sct_solve_traits_of(p.a, 2);
    /* nearly all of the weight is in the pair that v makes one-sided */
    if (rows[k].v > 0) assert_true(t.skewness > 0.9);
    if (rows[k].v == 0) assert_near(t.skewness, 0, 1e-12);
    assert_int_equal(t.dominance > 0.5, rows[k].dominated);
    sct_csr_free(&p.a);
  }
}

static void policy(void **state) {
  (void)state;
  const struct {
    sct_solve_traits traits;
    bool iterates;
    sct_preconditioner preconditioner;
  } rows[] = {
      {{1, 1000000, 0, 0}, false, SCT_AMG}, {{2, 10000, 0, 0}, false, SCT_AMG},
      {{2, 50000, 0, 0.1}, true, SCT_AMG},  {{2, 50000, 0, 0.9}, false, SCT_AMG_AGGRESSIVE},
      {{2, 50000, 1, 0.1}, false, SCT_ILU}, {{2, 100000, 0, 0.9}, true, SCT_AMG_AGGRESSIVE},
      {{2, 100000, 1, 0.1}, true, SCT_ILU}, {{3, 2000, 0, 0.1}, false, SCT_ILU},
      {{3, 3000, 0, 0.1}, true, SCT_ILU},   {{3, 200000, 0, 0.1}, true, SCT_AMG_AGGRESSIVE},
      {{3, 200000, 1, 0.1}, true, SCT_ILU}, {{2, 50000, 0, (double)NAN}, false, SCT_AMG_AGGRESSIVE},
  };
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    assert_int_equal(sct_solve_suits_iteration(&rows[k].traits), rows[k].iterates);
    assert_int_equal(sct_solve_preconditioner(&rows[k].traits), rows[k].preconditioner);
  }
}

int main(void) {
  const struct CMUnitTest policies[] = {
      cmocka_unit_test(traits),
      cmocka_unit_test(policy),
      cmocka_unit_test(too_large_to_fall_back),
  };
  const struct CMUnitTest solves[] = {
      cmocka_unit_test(meets_the_tolerance),
      cmocka_unit_test(iterations_are_limited),
      cmocka_unit_test(unreachable_tolerance_falls_back),
      cmocka_unit_test(no_preconditioner_falls_back),
      cmocka_unit_test(a_guess_saves_iterations),
      cmocka_unit_test(transposed),
      cmocka_unit_test(is_watched),
      cmocka_unit_test(factored_anew),
      cmocka_unit_test(is_foreseen),
  };
  sct_error err = {0};
  const int failed = cmocka_run_group_tests(policies, NULL, NULL);
  const sct_status there = sct_solver_load_iterative(&err);
  if (there == SCT_OK) return failed + cmocka_run_group_tests(solves, NULL, NULL);
  print_message("no iterative solver here: %s\n", err.text);
  return failed + (there != SCT_E_ARGUMENT);
}
