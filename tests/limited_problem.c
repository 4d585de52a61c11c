#include "limited_problem.h"

#include <stdlib.h>

sct_operator limited_operator(sct_scheme scheme) {
  sct_operator op = sct_operator_default(scheme, 2);
  op.upwind = SCT_UPWIND_LIMITED;
  return op;
}

static void pose_at(limited_problem *p, const posed *of, int64_t i) {
  const int dim = p->f.cloud.dim;
  const double *x = p->f.cloud.x + i * dim;
  p->mu[i] = of->mu;
  of->velocity(x, p->velocity + i * dim);
  if (of->source != NULL) p->source[i] = of->source(x, of->mu);
  if (p->f.inside[i]) return;
  const bool outlet = of->is_outlet != NULL && of->is_outlet(x, p->normal + i * dim);
  p->condition[i] = outlet ? SCT_NEUMANN : SCT_DIRICHLET;
  if (!outlet) p->phi[i] = p->value[i] = of->value(x);
}

limited_problem limited_problem_new(const posed *of, const sct_lattice *lattice,
                                    const sct_operator *op) {
  limited_problem p = {.f = fixture_lattice(lattice, op)};
  const int64_t n = p.f.cloud.n;
  double **const arrays[] = {&p.velocity, &p.mu, &p.value, &p.source, &p.normal, &p.phi};
  for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++) {
    *arrays[k] = fixture_alloc(n * lattice->dim, sizeof(double));
  }
  p.condition = fixture_alloc(n, 1);
  for (int64_t i = 0; i < n; i++) pose_at(&p, of, i);
  const sct_fields fields = {p.velocity, p.mu, p.source, NULL};
  const sct_boundary boundary = {p.condition, p.value, NULL, p.normal};
  sct_error err;
  expect_ok(sct_system_build(p.f.stencil, &fields, &boundary, NULL, &p.system, &err), &err);
  return p;
}

void limited_problem_clear(limited_problem *p) {
  double *const arrays[] = {p->velocity, p->mu, p->value, p->source, p->normal, p->phi};
  for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++) free(arrays[k]);
  free(p->condition);
  sct_system_free(&p->system);
  fixture_clear(&p->f);
}

sct_status limited_problem_solve(limited_problem *p, const sct_limited_options *options,
                                 sct_error *err) {
  sct_solve_options direct = {.dim = p->f.cloud.dim, .method = "direct"};
  sct_limited_relax(&direct);
  sct_solver *solver = NULL;
  sct_status status = sct_solver_analyse(p->system->matrix, &direct, &solver, err);
  if (status == SCT_OK) status = sct_solver_factor(solver, p->system->matrix, err);
  if (status == SCT_OK) {
    status = sct_limited_solve(p->system, solver, options, NULL, p->phi, &p->report, err);
  }
  sct_solver_free(&solver);
  return status;
}
