/* verify.iterative: what is iterated agrees with what is factored, to the tolerance, for every
 * scheme, dimension and preconditioner, steady and in time, with and without convection; the number
 * of iterations grows no faster than n^(1/d) with incomplete factors and hardly with multigrid. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "manufactured.h"

static const char *const PRECONDITIONERS[] = {"ilu", "amg"};

typedef struct {
  fixture f;
  manufactured m;
  sct_system *system;
  double *b, *x;
} problem;

/* The manufactured problem on a jittered lattice with every type of wall; `speed` > 0: its
 * velocities that many times, upwinded. */
static problem problem_new(int dim, int64_t cells, sct_scheme scheme, int degree, double speed) {
  sct_operator op = sct_operator_default(scheme, degree);
  sct_error err;
  problem p;
  if (speed > 0) op.upwind = SCT_UPWIND_COSINE;
  p.f = fixture_unit(dim, cells, 0.3, 11, &op);
  p.m = manufactured_new(&p.f, 0);
  manufactured_side(&p.m, SCT_SIDE_RIGHT, SCT_NEUMANN);
  if (dim > 1) manufactured_side(&p.m, SCT_SIDE_TOP, SCT_ROBIN);
  for (int64_t k = 0; k < p.f.cloud.n * dim; k++) p.m.velocity[k] *= speed;
  const sct_fields fields = manufactured_fields(&p.m);
  const sct_boundary boundary = manufactured_boundary(&p.m);
  expect_ok(sct_system_build(p.f.stencil, &fields, &boundary, NULL, &p.system, &err), &err);
  p.b = fixture_alloc(p.system->unknowns, sizeof *p.b);
  p.x = fixture_alloc(p.system->unknowns, sizeof *p.x);
  sct_system_rhs(p.system, p.m.value, p.b);
  return p;
}

static void problem_free(problem *p) {
  free(p->b);
  free(p->x);
  sct_system_free(&p->system);
  manufactured_free(&p->m);
  fixture_clear(&p->f);
}

static sct_solve_report solve(problem *p, const char *method, const char *preconditioner) {
  const sct_solve_options options = {.dim = p->f.cloud.dim,
                                     .method = method,
                                     .preconditioner = preconditioner,
                                     .is_equation = p->system->is_equation};
  sct_solver *solver;
  sct_error err;
  expect_ok(sct_solver_analyse(p->system->matrix, &options, &solver, &err), &err);
  expect_ok(sct_solver_factor(solver, p->system->matrix, &err), &err);
  expect_ok(sct_solver_solve(solver, p->b, false, p->x, &err), &err);
  const sct_solve_report report = *sct_solver_report(solver);
  sct_solver_free(&solver);
  return report;
}

static double distance(const double *x, const double *y, int64_t n) {
  double most = 0;
  for (int64_t i = 0; i < n; i++) most = fmax(most, fabs(x[i] - y[i]));
  return most;
}

/* Both preconditioners against the factors. phi is of size 1, and |A^-1| of D A some h^-2 at most,
 * hence the bound. */
static void compare(int dim, int64_t cells, sct_scheme scheme, int degree, double speed) {
  problem p = problem_new(dim, cells, scheme, degree, speed);
  const int64_t n = p.system->unknowns;
  double *direct = fixture_alloc(n, sizeof *direct);
  solve(&p, "direct", NULL);
  memcpy(direct, p.x, (size_t)n * sizeof *direct);
  for (int k = 0; k < 2; k++) {
    const sct_solve_report r = solve(&p, "iterative", PRECONDITIONERS[k]);
    const double off = distance(p.x, direct, n);
    print_message("%d-D %-5s %d speed %-6g %s %4d iterations: %.1e %s\n", dim,
                  sct_scheme_name(scheme), degree, speed, PRECONDITIONERS[k], r.iterations, off,
                  r.fallback);
    assert_string_equal(r.fallback, "");
    assert_string_equal(r.method, "iterative");
    assert_true(r.relative_residual <= 1e-10);
    assert_true(off <= 1e-10 * (double)(cells * cells));
  }
  free(direct);
  problem_free(&p);
}

static void steady_agrees(void **state) {
  (void)state;
  static const int64_t cells[] = {0, 200, 40, 14};
  for (int dim = 1; dim <= 3; dim++) {
    for (int scheme = 0; scheme < SCT_SCHEME_COUNT; scheme++) {
      for (int degree = 2; degree <= (scheme == SCT_LSMPS ? 4 : 2); degree++) {
        compare(dim, cells[dim], (sct_scheme)scheme, degree, 0);
      }
    }
  }
}

/* Cell Peclet numbers up to 1e4. */
static void convection_agrees(void **state) {
  (void)state;
  for (double speed = 1e2; speed < 1e7; speed *= 100) {
    compare(2, 40, SCT_LSMPS, 2, speed);
    compare(2, 40, SCT_PS, 2, speed);
    compare(3, 14, SCT_LSMPS, 2, speed);
  }
}

/* A march with each solver. */
static void time_agrees(void **state) {
  (void)state;
  for (int method = SCT_BACKWARD_EULER; method < SCT_MARCH_COUNT; method++) {
    for (int dim = 1; dim <= 3; dim++) {
      problem p = problem_new(dim, dim == 3 ? 10 : 30, SCT_LSMPS, 2, 1);
      const int64_t n = p.f.cloud.n;
      double *direct = fixture_alloc(n, sizeof *direct), *phi = fixture_alloc(n, sizeof *phi);
      for (int k = 0; k < 2; k++) {
        const sct_march_options options = {
            .method = (sct_march_method)method,
            .end = 0.1,
            .step = 0.005,
            .solve = {.dim = dim, .method = k == 0 ? "direct" : "iterative"}};
        sct_march_report report;
        sct_error err;
        memcpy(phi, p.m.exact, (size_t)n * sizeof *phi);
        expect_ok(sct_march(&p.system, &options, NULL, NULL, phi, &report, &err), &err);
        if (k == 0) memcpy(direct, phi, (size_t)n * sizeof *phi);
        assert_string_equal(report.solve.fallback, "");
        if (k == 1) assert_string_equal(report.solve.method, "iterative");
      }
      print_message("%s %d-D: %.1e\n", sct_march_name((sct_march_method)method), dim,
                    distance(phi, direct, n));
      assert_true(distance(phi, direct, n) <= 1e-7);
      free(direct);
      free(phi);
      problem_free(&p);
    }
  }
}

static void iterations_grow_slowly(void **state) {
  (void)state;
  static const int64_t cells[][2] = {{0}, {0}, {40, 160}, {10, 30}};
  for (int dim = 2; dim <= 3; dim++) {
    double count[2][2];
    for (int m = 0; m < 2; m++) {
      problem p = problem_new(dim, cells[dim][m], SCT_LSMPS, 2, 0);
      for (int k = 0; k < 2; k++) {
        count[k][m] = solve(&p, "iterative", PRECONDITIONERS[k]).iterations;
      }
      problem_free(&p);
    }
    const double ratio = (double)cells[dim][1] / (double)cells[dim][0];
    print_message("%d-D: n^(1/d) by %.1f, ilu %.0f to %.0f, amg %.0f to %.0f\n", dim, ratio,
                  count[0][0], count[0][1], count[1][0], count[1][1]);
    assert_true(count[0][1] <= 1.25 * ratio * count[0][0]);
    assert_true(count[1][1] <= 2 * count[1][0]);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(steady_agrees),
      cmocka_unit_test(convection_agrees),
      cmocka_unit_test(time_agrees),
      cmocka_unit_test(iterations_grow_slowly),
  };
  sct_error err = {0};
  const sct_status there = sct_solver_load_iterative(&err);
  if (there == SCT_OK) return cmocka_run_group_tests(tests, NULL, NULL);
  print_message("no iterative solver here: %s\n", err.text);
  return there != SCT_E_ARGUMENT;
}
