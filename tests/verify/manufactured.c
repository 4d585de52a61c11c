#include "manufactured.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

truth truth_at(int dim, const double *at, double time, double decay) {
  const double x = at[0], y = dim > 1 ? at[1] : 0.2 / 0.9, z = dim > 2 ? at[2] : 0;
  const double sx = sin(1.3 * x + 0.4), cx = cos(1.3 * x + 0.4);
  const double sy = sin(0.9 * y - 0.2), cy = cos(0.9 * y - 0.2);
  const double e = exp(0.5 * z - decay * time);
  const double grad_mu[3] = {0.3, 0.2, 0.1};
  truth t = {.phi = sx * cy * e,
             .gradient = {1.3 * cx * cy * e, -0.9 * sx * sy * e, 0.5 * sx * cy * e},
             .mu = 1 + 0.3 * x + (dim > 1 ? 0.2 * y : 0) + (dim > 2 ? 0.1 * z : 0),
             .u = {(dim > 1 ? y : 1) - 0.5, 0.5 - x, 0.3},
             .k = 0.5 + x};
  const double second[3] = {-1.69 * t.phi, -0.81 * t.phi, 0.25 * t.phi};
  t.source = (t.k - decay) * t.phi;
  for (int a = 0; a < dim; a++) {
    t.laplacian += second[a];
    t.source += t.u[a] * t.gradient[a] - grad_mu[a] * t.gradient[a];
  }
  t.source -= t.mu * t.laplacian;
  return t;
}

enum { ARRAYS = 9 };

static void arrays_of(manufactured *m, double **arrays[ARRAYS]) {
  double **const all[ARRAYS] = {&m->velocity, &m->diffusivity, &m->source,
                                &m->reaction, &m->value,       &m->coefficient,
                                &m->normal,   &m->exact,       &m->phi};
  memcpy(arrays, all, sizeof all);
}

/* The answer, source and boundary value of a point at a time. */
static void set_point(manufactured *m, int64_t i, double t) {
  const int dim = m->f->cloud.dim;
  const truth at = truth_at(dim, m->f->x + i * dim, t, m->decay);
  double slope = 0;
  for (int a = 0; a < dim; a++) slope += m->normal[i * dim + a] * at.gradient[a];
  m->exact[i] = at.phi;
  m->source[i] = at.source;
  m->value[i] = m->condition[i] == SCT_DIRICHLET ? at.phi
                : m->condition[i] == SCT_NEUMANN ? slope
                                                 : m->coefficient[i] * at.phi + slope;
}

static void set_time(manufactured *m, double t) {
  for (int64_t i = 0; i < m->f->cloud.n; i++) set_point(m, i, t);
}

manufactured manufactured_new(const fixture *f, double decay) {
  manufactured m = {.f = f, .decay = decay};
  double **arrays[ARRAYS];
  const int dim = f->cloud.dim;
  arrays_of(&m, arrays);
  for (int k = 0; k < ARRAYS; k++) *arrays[k] = fixture_alloc(f->cloud.n * dim, sizeof(double));
  m.condition = fixture_alloc(f->cloud.n, 1);
  for (int64_t i = 0; i < f->cloud.n; i++) {
    const truth t = truth_at(dim, f->x + i * dim, 0, decay);
    for (int a = 0; a < dim; a++) m.velocity[i * dim + a] = t.u[a];
    m.diffusivity[i] = t.mu;
    m.reaction[i] = t.k;
    m.coefficient[i] = 2;
    m.condition[i] = f->inside[i] ? SCT_INTERIOR : SCT_DIRICHLET;
  }
  set_time(&m, 0);
  return m;
}

void manufactured_free(manufactured *m) {
  double **arrays[ARRAYS];
  arrays_of(m, arrays);
  for (int k = 0; k < ARRAYS; k++) free(*arrays[k]);
  free(m->condition);
}

void manufactured_set(manufactured *m, int64_t i, sct_condition condition, const double *normal) {
  const int dim = m->f->cloud.dim;
  m->condition[i] = (uint8_t)condition;
  memcpy(m->normal + i * dim, normal, (size_t)dim * sizeof *normal);
  set_point(m, i, 0);
}

void manufactured_side(manufactured *m, sct_side side, sct_condition condition) {
  sct_group group;
  sct_error err;
  expect_ok(sct_lattice_group(&m->f->lattice, side, &group, &err), &err);
  for (int64_t k = 0; k < group.n; k++) {
    manufactured_set(m, group.index[k], condition,
                     group.normal + (group.normals == 1 ? 0 : k * m->f->cloud.dim));
  }
  sct_group_clear(&group);
}

sct_fields manufactured_fields(const manufactured *m) {
  return (sct_fields){m->velocity, m->diffusivity, m->source, m->reaction};
}

sct_boundary manufactured_boundary(const manufactured *m) {
  return (sct_boundary){m->condition, m->value, m->coefficient, m->normal};
}

static sct_system *assemble(const manufactured *m) {
  const sct_fields fields = manufactured_fields(m);
  const sct_boundary boundary = manufactured_boundary(m);
  const sct_work work = {.threads = 2};
  sct_system *system = NULL;
  sct_error err;
  expect_ok(sct_system_build(m->f->stencil, &fields, &boundary, &work, &system, &err), &err);
  return system;
}

static void put_dirichlet(const manufactured *m, double *phi) {
  for (int64_t i = 0; i < m->f->cloud.n; i++) {
    if (m->condition[i] == SCT_DIRICHLET) phi[i] = m->value[i];
  }
}

static double error_of(const manufactured *m) {
  return sct_norms_of(m->phi, m->exact, m->f->cloud.n, 1, m->f->inside).l2;
}

double manufactured_steady(manufactured *m) {
  const sct_solve_options options = {.dim = m->f->cloud.dim, .method = "auto"};
  sct_system *system = assemble(m);
  sct_solver *solver = NULL;
  sct_error err;
  double *b = fixture_alloc(system->unknowns, sizeof *b);
  double *x = fixture_alloc(system->unknowns, sizeof *x);
  put_dirichlet(m, m->phi);
  sct_system_rhs(system, m->phi, b);
  expect_ok(sct_solver_analyse(system->matrix, &options, &solver, &err), &err);
  expect_ok(sct_solver_factor(solver, system->matrix, &err), &err);
  expect_ok(sct_solver_solve(solver, b, false, x, &err), &err);
  for (int64_t row = 0; row < system->unknowns; row++) m->phi[system->point_of[row]] = x[row];
  sct_solver_free(&solver);
  sct_system_free(&system);
  free(b);
  free(x);
  return error_of(m);
}

static sct_status advance(void *context, double t, sct_system **system, double *phi,
                          sct_error *err) {
  manufactured *m = context;
  (void)err;
  set_time(m, t);
  sct_system_load(*system, m->source, m->value);
  put_dirichlet(m, phi);
  return SCT_OK;
}

double manufactured_in_time(manufactured *m, sct_march_method method, double step, double end) {
  const sct_march_options options = {.method = method,
                                     .end = end,
                                     .step = method == SCT_FORWARD_EULER ? 0 : step,
                                     .diffusion_number = 1,
                                     .solve = {.dim = m->f->cloud.dim}};
  const sct_march_problem problem = {
      .varies = SCT_VARIES_LOAD | SCT_VARIES_DIRICHLET, .context = m, .advance = advance};
  sct_error err;
  set_time(m, 0);
  memcpy(m->phi, m->exact, (size_t)m->f->cloud.n * sizeof *m->phi);
  sct_system *system = assemble(m);
  expect_ok(sct_march(&system, &options, &problem, NULL, m->phi, NULL, &err), &err);
  sct_system_free(&system);
  set_time(m, end);
  return error_of(m);
}
