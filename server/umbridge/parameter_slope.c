#include "parameter_slope.h"

#include <stdlib.h>

#include "expression_slope.h"

double **data_member(sct_data *d, int k) {
  double **const members[DATA_MEMBERS] = {&d->velocity, &d->diffusivity, &d->source,
                                          &d->reaction, &d->value,       &d->coefficient};
  return members[k];
}

static double *member_of(const sct_data *d, int k) {
  sct_data copy = *d;
  return *data_member(&copy, k);
}

static int64_t length(int k, int64_t n, int dim) {
  return k == 0 ? n * dim : n;
}

/* ---- Fields ---- */

static bool names(const field *f, int a, const char *name) {
  return f->component[a].text && expression_names(&f->component[a], name);
}

/* Is there nothing to take of component a: not named, or taken before and the same at all times? */
static bool is_settled(const field *f, int a, const parameter_slope *p) {
  return !names(f, a, p->name) || (p->taken && !f->component[a].varies);
}

/* Slope of component a of a field at its sites [n]; to be freed, NULL with t->error. */
static double *take_component(task *t, const field *f, int a, double time, parameter_slope *p) {
  double *slope = malloc((size_t)(f->on.n + 1) * sizeof *slope);
  if (!slope) (void)sct_fail(&t->error, SCT_E_MEMORY, -1, "no room for a derivative");
  p->varies |= f->component[a].varies;
  if (slope && expression_slope(t, &f->component[a], &f->on, time, p->name, p->value, slope)) {
    return slope;
  }
  free(slope);
  return NULL;
}

/* Slope of a field on all points into *out, made when first needed. */
static bool take_field(task *t, const field *f, double time, parameter_slope *p, double **out) {
  for (int a = 0; a < f->components; a++) {
    if (is_settled(f, a, p)) continue;
    if (!*out) *out = task_zeros(t, f->on.n * f->components, sizeof **out);
    double *slope = *out ? take_component(t, f, a, time, p) : NULL;
    if (!slope) return false;
    for (int64_t k = 0; k < f->on.n; k++) (*out)[k * f->components + a] = slope[k];
    free(slope);
  }
  return true;
}

/* ---- Conditions ---- */

/* Slope of an entry's field, spread to the points the entry owns. */
static bool take_entry(task *t, const solve_input *s, int64_t e, const field *f, double time,
                       parameter_slope *p, double **out) {
  if (is_settled(f, 0, p)) return true;
  if (!*out) *out = task_zeros(t, s->cloud.cloud.n, sizeof **out);
  double *slope = *out ? take_component(t, f, 0, time, p) : NULL;
  if (!slope) return false;
  for (int64_t k = 0; k < f->on.n; k++) {
    const int32_t i = f->on.place[k];
    if (s->boundary.owner[i] == e) (*out)[i] = slope[k];
  }
  free(slope);
  return true;
}

static bool take_boundary(task *t, const solve_input *s, double time, parameter_slope *p) {
  for (int64_t e = 0; e < s->boundary.entries; e++) {
    const boundary_entry *entry = &s->boundary.entry[e];
    if (!take_entry(t, s, e, &entry->value, time, p, &p->data.value)) return false;
    if (entry->type != SCT_ROBIN) continue;
    if (!take_entry(t, s, e, &entry->coefficient, time, p, &p->data.coefficient)) return false;
  }
  return true;
}

bool parameter_slope_take(task *t, const solve_input *s, double time, parameter_slope *p) {
  const bool good = take_field(t, &s->velocity, time, p, &p->data.velocity) &&
                    take_field(t, &s->diffusivity, time, p, &p->data.diffusivity) &&
                    take_field(t, &s->source, time, p, &p->data.source) &&
                    take_field(t, &s->reaction, time, p, &p->data.reaction) &&
                    (p->taken || take_field(t, &s->initial, s->march.start, p, &p->initial)) &&
                    take_boundary(t, s, time, p);
  p->taken = true;
  return good;
}

/* ---- What to do with it ---- */

bool parameter_slope_moves(const parameter_slope *p) {
  return p->data.velocity || p->data.diffusivity;
}

bool parameter_slope_weighs(const parameter_slope *p) {
  return parameter_slope_moves(p) || p->data.reaction || p->data.coefficient;
}

double parameter_slope_dot(const parameter_slope *p, const sct_data *gradient, int64_t n, int dim) {
  double sum = 0;
  for (int k = 0; k < DATA_MEMBERS; k++) {
    const double *change = member_of(&p->data, k), *g = member_of(gradient, k);
    for (int64_t i = 0; change && i < length(k, n, dim); i++) sum += g[i] * change[i];
  }
  return sum;
}

void parameter_slope_add(const parameter_slope *p, double factor, int64_t n, int dim,
                         sct_data *sum) {
  for (int k = 0; k < DATA_MEMBERS; k++) {
    const double *change = member_of(&p->data, k);
    double *to = member_of(sum, k);
    for (int64_t i = 0; change && i < length(k, n, dim); i++) to[i] += factor * change[i];
  }
}

bool parameter_slope_zeros(task *t, const parameter_slope *p, int64_t count, int64_t n, int dim,
                           sct_data *zeros) {
  *zeros = (sct_data){0};
  for (int k = 0; k < DATA_MEMBERS; k++) {
    bool changes = false;
    for (int64_t i = 0; i < count; i++) changes = changes || member_of(&p[i].data, k);
    if (!changes) continue;
    *data_member(zeros, k) = task_zeros(t, length(k, n, dim), sizeof(double));
    if (!*data_member(zeros, k)) return false;
  }
  return true;
}
