/* Threads change no bit: spacing, rows applied, systems, marches and solutions are the same for
 * every number of them, on clouds large enough for each to get some. */
#include <stdlib.h>
#include <string.h>

#include "fixture.h"

enum { THREADS_MAX = 5 };

typedef struct {
  double *nearest, *gradient, *laplacian, *phi, *solution;
  sct_system *system;
} results;

static void expect_same(const void *a, const void *b, int64_t n, size_t size) {
  assert_memory_equal(a, b, (size_t)n * size);
}

static void expect_same_matrix(const sct_csr *a, const sct_csr *b) {
  expect_same(a->start, b->start, a->rows + 1, sizeof *a->start);
  expect_same(a->column, b->column, sct_csr_entries(a), sizeof *a->column);
  expect_same(a->value, b->value, sct_csr_entries(a), sizeof *a->value);
}

static void march(const fixture *f, const sct_work *work, results *r) {
  const sct_march_options options = {.method = SCT_FORWARD_EULER,
                                     .end = 5 * sct_march_stable_step(r->system, NULL),
                                     .diffusion_number = 0.9,
                                     .solve = {.dim = f->cloud.dim}};
  sct_error err;
  for (int64_t i = 0; i < f->cloud.n; i++) r->phi[i] = f->x[i * f->cloud.dim] * f->inside[i];
  expect_ok(sct_march(&r->system, &options, NULL, work, r->phi, NULL, &err), &err);
}

static void solve(const fixture *f, results *r) {
  const sct_solve_options options = {.dim = f->cloud.dim};
  sct_solver *solver;
  sct_error err;
  expect_ok(sct_solver_analyse(r->system->matrix, &options, &solver, &err), &err);
  expect_ok(sct_solver_factor(solver, r->system->matrix, &err), &err);
  expect_ok(sct_solver_solve(solver, r->system->load, false, r->solution, &err), &err);
  sct_solver_free(&solver);
}

/* Everything, on a search and stencils of its own. */
static results all_of(const fixture *f, const sct_operator *op, int threads) {
  const int64_t n = f->cloud.n;
  const sct_work work = {.threads = threads};
  uint8_t *condition = fixture_alloc(n, 1);
  double *mu = fixture_alloc(n, sizeof *mu), *field = fixture_alloc(n, sizeof *field);
  results r = {fixture_alloc(n, sizeof(double)), fixture_alloc(n * f->cloud.dim, sizeof(double)),
               fixture_alloc(n, sizeof(double)), fixture_alloc(n, sizeof(double)),
               fixture_alloc(n, sizeof(double)), NULL};
  sct_search *search;
  sct_stencil *stencil;
  sct_error err;
  for (int64_t i = 0; i < n; i++) {
    condition[i] = f->inside[i] ? SCT_INTERIOR : SCT_DIRICHLET;
    mu[i] = 1 + f->x[i * f->cloud.dim];
    field[i] = mu[i] * mu[i];
  }
  const sct_fields fields = {.diffusivity = mu, .source = field};
  const sct_boundary boundary = {.condition = condition};
  expect_ok(sct_search_build(&f->cloud, 0, SCT_SEARCH_AUTO, &work, &search, &err), &err);
  expect_ok(sct_search_nearest(search, &work, r.nearest, &err), &err);
  expect_ok(sct_stencil_build(&f->cloud, search, f->spacing, op, 500, &work, &stencil, &err), &err);
  expect_ok(sct_stencil_apply(stencil, field, &work, NULL, r.gradient, r.laplacian, &err), &err);
  expect_ok(sct_system_build(stencil, &fields, &boundary, &work, &r.system, &err), &err);
  march(f, &work, &r);
  solve(f, &r);
  sct_stencil_free(&stencil);
  sct_search_free(&search);
  free(condition);
  free(mu);
  free(field);
  return r;
}

static void results_free(results *r) {
  double *const arrays[] = {r->nearest, r->gradient, r->laplacian, r->phi, r->solution};
  for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++) free(arrays[k]);
  sct_system_free(&r->system);
}

static void change_nothing(const sct_operator *op, int dim, int64_t cells) {
  fixture f = fixture_unit(dim, cells, 0.3, 5, op);
  const int64_t n = f.cloud.n;
  results one = all_of(&f, op, 1);
  for (int threads = 2; threads <= THREADS_MAX; threads++) {
    results many = all_of(&f, op, threads);
    expect_same(one.nearest, many.nearest, n, sizeof(double));
    expect_same(one.gradient, many.gradient, n * dim, sizeof(double));
    expect_same(one.laplacian, many.laplacian, n, sizeof(double));
    expect_same(one.phi, many.phi, n, sizeof(double));
    expect_same(one.solution, many.solution, one.system->unknowns, sizeof(double));
    expect_same_matrix(one.system->matrix, many.system->matrix);
    expect_same_matrix(one.system->coupling, many.system->coupling);
    results_free(&many);
  }
  results_free(&one);
  fixture_clear(&f);
}

/* Factored in two dimensions at this size, iterated with in three. */
static void plane(void **state) {
  (void)state;
  const sct_operator op = sct_operator_default(SCT_LSMPS, 2);
  change_nothing(&op, 2, 130);
}

static void space(void **state) {
  (void)state;
  const sct_operator op = sct_operator_default(SCT_IPS, 2);
  change_nothing(&op, 3, 25);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(plane), cmocka_unit_test(space)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
