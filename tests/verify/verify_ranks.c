/* verify.ranks: what many processes solve together agrees with what one factors, to the tolerance
 * of the iteration, whatever their number; every scheme, 1-D to 3-D, convection, both
 * preconditioners. Started by mpiexec, or alone as one rank of one. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "manufactured.h"

static sct_ranks *ranks;

typedef struct {
  fixture f;
  manufactured m;
  sct_operator op;
  sct_fields fields;
  sct_boundary boundary;
} problem;

static problem problem_new(int dim, int64_t cells, sct_operator op, double speed) {
  problem p = {.op = op};
  p.f = fixture_unit(dim, cells, 0.4, 31, &op);
  p.m = manufactured_new(&p.f, 0);
  manufactured_side(&p.m, SCT_SIDE_RIGHT, SCT_NEUMANN);
  if (dim > 1) manufactured_side(&p.m, SCT_SIDE_TOP, SCT_ROBIN);
  for (int64_t k = 0; k < p.f.cloud.n * dim; k++) p.m.velocity[k] *= speed;
  p.fields = manufactured_fields(&p.m);
  p.boundary = manufactured_boundary(&p.m);
  return p;
}

static void problem_free(problem *p) {
  manufactured_free(&p->m);
  fixture_clear(&p->f);
}

/* By factors, in one process. */
static void solve_alone(problem *p, double *phi, int64_t *nonzeros) {
  const sct_solve_options options = {.dim = p->f.cloud.dim, .method = "direct"};
  sct_system *system;
  sct_solver *solver;
  sct_error err;
  expect_ok(sct_system_build(p->f.stencil, &p->fields, &p->boundary, NULL, &system, &err), &err);
  double *b = fixture_alloc(system->unknowns, sizeof *b);
  double *x = fixture_alloc(system->unknowns, sizeof *x);
  sct_system_rhs(system, p->m.value, b);
  expect_ok(sct_solver_analyse(system->matrix, &options, &solver, &err), &err);
  expect_ok(sct_solver_factor(solver, system->matrix, &err), &err);
  expect_ok(sct_solver_solve(solver, b, false, x, &err), &err);
  memcpy(phi, p->m.value, (size_t)p->f.cloud.n * sizeof *phi);
  for (int64_t row = 0; row < system->unknowns; row++) phi[system->point_of[row]] = x[row];
  *nonzeros = sct_csr_entries(system->matrix);
  sct_solver_free(&solver);
  sct_system_free(&system);
  free(b);
  free(x);
}

static sct_status solve_together(problem *p, const sct_solve_options *options, double *phi,
                                 sct_solve_report *solve, sct_ranks_report *report,
                                 sct_error *err) {
  sct_partition *partition;
  expect_ok(sct_partition_build(&p->f.cloud, sct_ranks_count(ranks), false, &partition, err), err);
  const sct_part_problem all = {&p->f.cloud,        partition,  p->f.spacing, &p->op,
                                FIXTURE_NEIGHBOURS, &p->fields, &p->boundary};
  memcpy(phi, p->m.value, (size_t)p->f.cloud.n * sizeof *phi);
  const sct_status status = sct_ranks_solve(ranks, &all, options, NULL, phi, solve, report, err);
  sct_partition_free(&partition);
  return status;
}

static void say(const problem *p, const sct_solve_report *solve, const sct_ranks_report *report,
                double off) {
  if (sct_ranks_rank(ranks) != 0) return;
  print_message(
      "%d ranks, %d-D %-5s: %s, %-9s %3d iterations, residual %.1e, halo %lld of %lld, "
      "off %.1e\n",
      sct_ranks_count(ranks), p->f.cloud.dim, sct_scheme_name(p->op.scheme), solve->krylov,
      solve->preconditioner, solve->iterations, solve->relative_residual, (long long)report->halo,
      (long long)p->f.cloud.n, off);
}

/* phi is of size 1, and |A^-1| of D A some h^-2 at most, hence the bound. */
static void compare(int dim, int64_t cells, sct_operator op, double speed,
                    const char *preconditioner) {
  problem p = problem_new(dim, cells, op, speed);
  const int64_t n = p.f.cloud.n;
  const sct_solve_options options = {.dim = dim, .preconditioner = preconditioner};
  double *alone = fixture_alloc(n, sizeof *alone), *phi = fixture_alloc(n, sizeof *phi), off = 0;
  sct_solve_report solve;
  sct_ranks_report report;
  sct_error err;
  int64_t nonzeros;
  solve_alone(&p, alone, &nonzeros);
  expect_ok(solve_together(&p, &options, phi, &solve, &report, &err), &err);
  for (int64_t i = 0; i < n; i++) off = fmax(off, fabs(phi[i] - alone[i]));
  say(&p, &solve, &report, off);
  assert_true(solve.relative_residual <= 1e-10);
  assert_true(solve.residual < 1e-7);
  assert_true(off <= 1e-10 * (double)(cells * cells));
  assert_true(solve.history_count > 0 && solve.history[0] > 1e-10);
  assert_int_equal(report.nonzeros, nonzeros);
  assert_true((report.halo > 0) == (sct_ranks_count(ranks) > 1));
  free(alone);
  free(phi);
  problem_free(&p);
}

static void every_scheme(void **state) {
  (void)state;
  static const int64_t cells[] = {0, 100, 40, 12};
  for (int dim = 1; dim <= 3; dim++) {
    for (int k = 0; k < SCT_SCHEME_COUNT; k++) {
      compare(dim, cells[dim], sct_operator_default((sct_scheme)k, 2), 1, k % 2 ? "amg" : "ilu");
    }
  }
}

/* By its own choice of preconditioner, with and without convection that has the say. */
static void convection(void **state) {
  (void)state;
  for (double speed = 1; speed < 1e6; speed *= 1000) {
    sct_operator op = sct_operator_default(SCT_LSMPS, 2);
    op.upwind = SCT_UPWIND_COSINE;
    compare(2, 60, op, speed, NULL);
    compare(3, 12, op, speed, NULL);
  }
}

/* Some ranks have no points at all, or none that is unknown. */
static void few_points(void **state) {
  (void)state;
  compare(1, 3, sct_operator_default(SCT_PS, 2), 0, NULL);
  compare(2, 3, sct_operator_default(SCT_PS, 2), 0, NULL);
}

/* All ranks hear of the failure of one. */
static void failures(void **state) {
  (void)state;
  problem p = problem_new(2, 20, sct_operator_default(SCT_PS, 2), 1);
  double *phi = fixture_alloc(p.f.cloud.n, sizeof *phi);
  const sct_solve_options options = {.dim = 2}, few = {.dim = 2, .max_iterations = 2};
  sct_solve_report solve;
  sct_ranks_report report;
  sct_error err;
  assert_int_equal(solve_together(&p, &few, phi, &solve, &report, &err), SCT_E_CONVERGENCE);
  p.f.x[2 * (5 * 21 + 7)] = 50;
  assert_int_equal(solve_together(&p, &options, phi, &solve, &report, &err), SCT_E_DEFICIENT);
  p.f.x[2 * (5 * 21 + 7)] = p.f.x[2 * (5 * 21 + 8)];
  p.f.x[2 * (5 * 21 + 7) + 1] = p.f.x[2 * (5 * 21 + 8) + 1];
  assert_int_equal(solve_together(&p, &options, phi, &solve, &report, &err), SCT_E_COINCIDENT);
  p.op.upwind = SCT_UPWIND_LIMITED;
  assert_int_equal(solve_together(&p, &options, phi, &solve, &report, &err), SCT_E_ARGUMENT);
  free(phi);
  problem_free(&p);
}

/* Iterations of blocks: more than of the whole, but not many more. */
static void blocks_cost_iterations(void **state) {
  (void)state;
  problem p = problem_new(2, 80, sct_operator_default(SCT_LSMPS, 2), 1);
  double *phi = fixture_alloc(p.f.cloud.n, sizeof *phi);
  sct_solve_report solve;
  sct_ranks_report report;
  sct_error err;
  for (int k = 0; k < 2; k++) {
    const sct_solve_options options = {.dim = 2, .preconditioner = k == 0 ? "ilu" : "amg"};
    expect_ok(solve_together(&p, &options, phi, &solve, &report, &err), &err);
    say(&p, &solve, &report, 0);
    assert_true(solve.iterations <= (k == 0 ? 120 : 15));
    assert_string_equal(solve.preconditioner, k == 1                       ? "amg"
                                              : sct_ranks_count(ranks) > 1 ? "block ilu"
                                                                           : "ilu");
  }
  free(phi);
  problem_free(&p);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_scheme),
      cmocka_unit_test(convection),
      cmocka_unit_test(few_points),
      cmocka_unit_test(failures),
      cmocka_unit_test(blocks_cost_iterations),
  };
  sct_error err = {0};
  const sct_status there = sct_ranks_open(&ranks, &err);
  if (there != SCT_OK) print_message("no parallel runs here: %s\n", err.text);
  if (there != SCT_OK) return there != SCT_E_ARGUMENT;
  const int failed = cmocka_run_group_tests(tests, NULL, NULL);
  sct_ranks_close(&ranks);
  return failed;
}
