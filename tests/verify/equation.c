#include "equation.h"

#include <stdlib.h>
#include <string.h>

enum { MEMBERS = 6 };

/* Member k of the data and its length. */
static double **member(sct_data *d, int k) {
  double **const all[MEMBERS] = {&d->velocity, &d->diffusivity, &d->source,
                                 &d->reaction, &d->value,       &d->coefficient};
  return all[k];
}
static int64_t length(const equation *e, int k) {
  return k == 0 ? e->n * e->dim : e->n;
}

sct_data equation_zeros(const equation *e) {
  sct_data d;
  for (int k = 0; k < MEMBERS; k++) *member(&d, k) = fixture_alloc(length(e, k), sizeof(double));
  return d;
}

void equation_free(sct_data *d) {
  for (int k = 0; k < MEMBERS; k++) free(*member(d, k));
}

double equation_dot(const equation *e, const sct_data *a, const sct_data *b) {
  sct_data x = *a, y = *b;
  double sum = 0;
  for (int k = 0; k < MEMBERS; k++) {
    for (int64_t i = 0; i < length(e, k); i++) sum += (*member(&x, k))[i] * (*member(&y, k))[i];
  }
  return sum;
}

/* A side has one normal for all its points. */
static void impose(equation *e, sct_side side, sct_condition condition) {
  sct_group group;
  sct_error err;
  expect_ok(sct_lattice_group(&e->f.lattice, side, &group, &err), &err);
  for (int64_t k = 0; k < group.n; k++) {
    const int64_t i = group.index[k];
    e->condition[i] = (uint8_t)condition;
    memcpy(e->normal + i * e->dim, group.normal, (size_t)e->dim * sizeof(double));
  }
  sct_group_clear(&group);
}

static void fill(double *value, int64_t n, double low, double high, uint64_t *seed) {
  for (int64_t i = 0; i < n; i++) value[i] = low + (high - low) * fixture_random(seed);
}

static void make_data(equation *e, bool still, uint64_t *seed) {
  static const double low[MEMBERS] = {-3, 0.4, -1, 0.1, -1, 0.5};
  static const double high[MEMBERS] = {5, 1.2, 2, 0.9, 1, 2};
  e->data = equation_zeros(e);
  e->change = equation_zeros(e);
  for (int k = 0; k < MEMBERS; k++) {
    if (k > 0 || !still) fill(*member(&e->data, k), length(e, k), low[k], high[k], seed);
    fill(*member(&e->change, k), length(e, k), -0.3, 0.3, seed);
  }
  for (int64_t i = 0; i < e->n; i++) {
    if (e->condition[i] != SCT_ROBIN) e->change.coefficient[i] = 0;
  }
}

equation equation_make(int dim, const sct_operator *op, bool still, uint64_t seed) {
  static const int64_t cells[] = {0, 12, 6, 4};
  equation e = {.f = fixture_unit(dim, cells[dim], 0.2, seed, op), .dim = dim};
  e.n = e.f.cloud.n;
  e.condition = fixture_alloc(e.n, 1);
  e.normal = fixture_alloc(e.n * dim, sizeof *e.normal);
  impose(&e, SCT_SIDE_RIGHT, SCT_ROBIN);
  if (dim > 1) impose(&e, SCT_SIDE_BOTTOM, SCT_NEUMANN);
  if (dim > 2) impose(&e, SCT_SIDE_BACK, SCT_NEUMANN);
  if (dim > 2) impose(&e, SCT_SIDE_FRONT, SCT_DIRICHLET);
  if (dim > 1) impose(&e, SCT_SIDE_TOP, SCT_DIRICHLET);
  impose(&e, SCT_SIDE_LEFT, SCT_DIRICHLET);
  make_data(&e, still, &seed);
  e.initial = fixture_alloc(e.n, sizeof(double));
  e.initial_change = fixture_alloc(e.n, sizeof(double));
  fill(e.initial, e.n, -1, 1, &seed);
  fill(e.initial_change, e.n, -1, 1, &seed);
  return e;
}

void equation_clear(equation *e) {
  fixture_clear(&e->f);
  free(e->condition);
  free(e->normal);
  free(e->initial);
  free(e->initial_change);
  equation_free(&e->data);
  equation_free(&e->change);
}

equation_data equation_at(const equation *e, double h) {
  equation_data d = {.at = equation_zeros(e)};
  sct_data data = e->data, change = e->change;
  for (int k = 0; k < MEMBERS; k++) {
    const double *from = *member(&data, k), *along = *member(&change, k);
    double *to = *member(&d.at, k);
    for (int64_t i = 0; i < length(e, k); i++) to[i] = from[i] + h * along[i];
  }
  d.fields = (sct_fields){d.at.velocity, d.at.diffusivity, d.at.source, d.at.reaction};
  d.boundary = (sct_boundary){e->condition, d.at.value, d.at.coefficient, e->normal};
  return d;
}

void equation_data_clear(equation_data *d) {
  equation_free(&d->at);
}

sct_system *equation_system(const equation *e, double h) {
  sct_system *system = NULL;
  sct_error err;
  equation_data d = equation_at(e, h);
  expect_ok(sct_system_build(e->f.stencil, &d.fields, &d.boundary, NULL, &system, &err), &err);
  equation_data_clear(&d);
  return system;
}
