/* Two passes over the points: the first counts the entries of each row, the second fills them in,
 * so that threads write side by side into arrays of the right size. */
#include "scatter/slope.h"

#include <math.h>
#include <string.h>

#include "alloc.h"
#include "length.h"
#include "points.h"

/* Rows of unknowns, columns of points. */
struct sct_slope {
  int dim;
  int64_t rows;
  int64_t *start;   /* [rows+1]; NULL: rows are constant */
  int32_t *column;  /* [entries] */
  double *own;      /* [entries] d a_ij / d mu_i */
  double *other;    /* [entries] d a_ij / d mu_j */
  double *velocity; /* [entries][dim] d a_ij / d u_i */
};

typedef struct {
  const sct_stencil *stencil;
  const sct_fields *fields;
  const sct_system *system;
  bool diffuses;
  sct_slope *slope;
} survey;

/* ---- One row ---- */

/* Differences of fourth order over steps of `delta`: f' = sum_k weight_k f(at_k delta) / delta. */
typedef struct {
  int points;
  double at[5], weight[5];
} differences;
static const differences central = {4, {-2, -1, 1, 2}, {1. / 12, -2. / 3, 2. / 3, -1. / 12}};
static const differences forward = {
    5, {0, 1, 2, 3, 4}, {-25. / 12, 4, -3, 4. / 3, -1. / 4}}; /* where f ends at 0 */

static const double relative_step = 1e-3;

/* The row as the system has it (assemble.c), with the gradient in any case: where u = 0 now, it is
 * what a change of u brings. */
static sct_status take_row(const survey *v, int64_t i, const double *u, double mu, sct_room *room,
                           sct_row *row, sct_error *err) {
  const int want = SCT_ROW_GRADIENT | SCT_ROW_LAPLACIAN | (v->diffuses ? SCT_ROW_SOLVE : 0);
  const sct_row_request request = {want, u, mu, NULL};
  return sct_stencil_row(v->stencil, i, &request, room, row, err);
}

static const double *velocity_of(const survey *v, int64_t i) {
  const int dim = v->slope->dim;
  const double *u = v->fields->velocity == NULL ? NULL : v->fields->velocity + i * dim;
  return u != NULL && sct_length(u, dim) > 0 ? u : NULL;
}

/* Adds factor * u . g_ij to every entry `out` [row.n] strides apart. */
static void add_transport(const sct_row *row, const double *u, int dim, double factor, double *out,
                          int stride) {
  for (int a = 0; a < dim; a++) {
    const double *g = row->gradient + a * row->n;
    for (int64_t k = 0; k < row->n; k++) out[k * stride] += factor * u[a] * g[k];
  }
}

/* Which of the data of a row is varied: a component of u, or mu. */
typedef struct {
  int component; /* of u; -1: mu */
  double delta;
  const differences *by;
  double *out; /* entries, strides apart; minus the slope of u . g_ij is added */
  int stride;
} variation;

static sct_status vary(const survey *v, int64_t i, const variation *of, sct_room *room,
                       sct_error *err) {
  const sct_slope *s = v->slope;
  const int64_t first = s->start[v->system->row_of[i]];
  const int64_t n = s->start[v->system->row_of[i] + 1] - first;
  for (int k = 0; k < of->by->points; k++) {
    double u[SCT_DIM_MAX], mu = v->fields->diffusivity[i];
    memcpy(u, v->fields->velocity + i * s->dim, (size_t)s->dim * sizeof *u);
    *(of->component < 0 ? &mu : &u[of->component]) += of->by->at[k] * of->delta;
    sct_row row;
    sct_status status = take_row(v, i, u, mu, room, &row, err);
    if (status != SCT_OK) return status;
    if (row.n != n || memcmp(row.index, s->column + first, (size_t)n * sizeof *row.index) != 0) {
      return sct_fail(err, SCT_E_ARGUMENT, i,
                      "has a support that changes with the velocity, needs a wider one or no "
                      "upwinding to be differentiated");
    }
    add_transport(&row, u, s->dim, -of->by->weight[k] / of->delta, of->out, of->stride);
  }
  return SCT_OK;
}

/* Slopes of -u . g_ij(u, mu), upwinded. */
static sct_status vary_upwinded(const survey *v, int64_t i, const double *u, sct_room *room,
                                sct_error *err) {
  const sct_slope *s = v->slope;
  const int64_t first = s->start[v->system->row_of[i]];
  const double speed = sct_length(u, s->dim), mu = v->fields->diffusivity[i];
  for (int a = 0; a < s->dim; a++) {
    const variation of = {a, relative_step * speed, &central, s->velocity + first * s->dim + a,
                          s->dim};
    sct_status status = vary(v, i, &of, room, err);
    if (status != SCT_OK) return status;
  }
  const double scale = mu > 0 ? mu : speed * sct_stencil_spacing(v->stencil);
  const variation of = {-1, relative_step * scale, mu > 0 ? &central : &forward, s->own + first, 1};
  return vary(v, i, &of, room, err);
}

static bool is_upwinded(const survey *v) {
  return sct_stencil_operator(v->stencil)->upwind != SCT_UPWIND_NONE;
}

static sct_status fill_row(void *context, int64_t i, sct_room *room, sct_error *err) {
  const survey *v = context;
  const sct_slope *s = v->slope;
  const int32_t r = v->system->row_of[i];
  if (r < 0 || !v->system->is_equation[r]) return SCT_OK;
  const int64_t first = s->start[r];
  const double *u = velocity_of(v, i);
  sct_row row;
  sct_status status = take_row(v, i, u, v->fields->diffusivity[i], room, &row, err);
  if (status != SCT_OK) return status;
  memcpy(s->column + first, row.index, (size_t)row.n * sizeof *s->column);
  const bool numeric = u != NULL && is_upwinded(v);
  for (int64_t k = 0; k < row.n; k++) {
    s->own[first + k] = s->other[first + k] = 0.5 * row.laplacian[k];
    for (int a = 0; a < s->dim; a++) {
      s->velocity[(first + k) * s->dim + a] = numeric ? 0 : -row.gradient[a * row.n + k];
    }
  }
  return numeric ? vary_upwinded(v, i, u, room, err) : SCT_OK;
}

static sct_status count_row(void *context, int64_t i, sct_room *room, sct_error *err) {
  const survey *v = context;
  const int32_t r = v->system->row_of[i];
  sct_row row;
  if (r < 0 || !v->system->is_equation[r]) return SCT_OK;
  sct_status status = take_row(v, i, velocity_of(v, i), v->fields->diffusivity[i], room, &row, err);
  if (status == SCT_OK) v->slope->start[r + 1] = row.n;
  return status;
}

/* ---- All rows ---- */

static sct_status allocate_entries(sct_slope *s, sct_error *err) {
  for (int64_t r = 0; r < s->rows; r++) s->start[r + 1] += s->start[r];
  const int64_t entries = s->start[s->rows];
  sct_status status = sct_alloc(&s->column, entries, sizeof *s->column, err);
  if (status == SCT_OK) status = sct_alloc(&s->own, entries, sizeof *s->own, err);
  if (status == SCT_OK) status = sct_alloc(&s->other, entries, sizeof *s->other, err);
  if (status == SCT_OK) {
    status = sct_alloc(&s->velocity, entries, (size_t)s->dim * sizeof *s->velocity, err);
  }
  return status;
}

static sct_status take_rows(survey *v, const sct_work *work, sct_error *err) {
  const int64_t n = v->system->n;
  sct_status status = sct_alloc_zero(&v->slope->start, v->slope->rows + 1, sizeof(int64_t), err);
  if (status == SCT_OK) status = sct_points_run(v->stencil, 0, n, work, count_row, v, err);
  if (status == SCT_OK) status = allocate_entries(v->slope, err);
  if (status == SCT_OK) status = sct_work_report(work, "slope", 0, err);
  if (status == SCT_OK) status = sct_points_run(v->stencil, 0, n, work, fill_row, v, err);
  return status;
}

sct_status sct_slope_build(const sct_stencil *stencil, const sct_fields *fields,
                           const sct_system *system, bool moving, const sct_work *work,
                           sct_slope **out, sct_error *err) {
  survey v = {.stencil = stencil, .fields = fields, .system = system};
  *out = NULL;
  if (system->limited != NULL) {
    return sct_fail(err, SCT_E_ARGUMENT, -1, "upwind limited has no slopes, take another");
  }
  sct_status status = sct_alloc_zero(&v.slope, 1, sizeof *v.slope, err);
  if (status != SCT_OK) return status;
  v.slope->dim = sct_stencil_cloud(stencil)->dim;
  v.slope->rows = system->unknowns;
  for (int64_t i = 0; i < system->n; i++) v.diffuses = v.diffuses || fields->diffusivity[i] > 0;
  if (moving) status = take_rows(&v, work, err);
  if (status != SCT_OK) sct_slope_free(&v.slope);
  *out = v.slope;
  return status;
}

void sct_slope_free(sct_slope **slope) {
  if (*slope == NULL) return;
  sct_release(&(*slope)->start);
  sct_release(&(*slope)->column);
  sct_release(&(*slope)->own);
  sct_release(&(*slope)->other);
  sct_release(&(*slope)->velocity);
  sct_release(slope);
}

/* ---- R' ---- */

/* sum_j a'_ij (phi_i - phi_j) of row r = that of point i                                 (2) */
static double moved(const sct_slope *s, int64_t r, int64_t i, const sct_data *d,
                    const double *phi) {
  double sum = 0;
  for (int64_t e = s->start[r]; e < s->start[r + 1]; e++) {
    const int32_t j = s->column[e];
    double slope = 0;
    if (d->diffusivity != NULL) {
      slope = s->own[e] * d->diffusivity[i] + s->other[e] * d->diffusivity[j];
    }
    for (int a = 0; d->velocity != NULL && a < s->dim; a++) {
      slope += s->velocity[e * s->dim + a] * d->velocity[i * s->dim + a];
    }
    sum += slope * (phi[i] - phi[j]);
  }
  return sum;
}

static double slope_of_equation(const sct_slope *s, int64_t r, int64_t i, const sct_data *d,
                                const double *phi) {
  double slope = d->source == NULL ? 0 : -d->source[i];
  if (d->reaction != NULL) slope += d->reaction[i] * phi[i];
  if (d->diffusivity != NULL || d->velocity != NULL) slope += moved(s, r, i, d, phi);
  return slope;
}

static double slope_of_condition(int64_t i, const sct_data *d, const double *phi) {
  double slope = d->value == NULL ? 0 : -d->value[i];
  if (d->coefficient != NULL) slope += d->coefficient[i] * phi[i];
  return slope;
}

void sct_slope_apply(const sct_slope *slope, const sct_system *system, const sct_data *change,
                     const double *phi, double *r) {
  for (int64_t row = 0; row < system->unknowns; row++) {
    const int64_t i = system->point_of[row];
    r[row] = system->is_equation[row] ? slope_of_equation(slope, row, i, change, phi)
                                      : slope_of_condition(i, change, phi);
  }
  if (change->value != NULL) sct_csr_multiply_add(system->coupling, 1, change->value, r);
}

/* ---- its transpose ---- */

/* The transpose of `moved`, for one row of weight w. */
static void spread(const sct_slope *s, int64_t r, int64_t i, double w, const double *phi,
                   sct_data *g) {
  for (int64_t e = s->start[r]; e < s->start[r + 1]; e++) {
    const int32_t j = s->column[e];
    const double share = w * (phi[i] - phi[j]);
    if (g->diffusivity != NULL) {
      g->diffusivity[i] += s->own[e] * share;
      g->diffusivity[j] += s->other[e] * share;
    }
    for (int a = 0; g->velocity != NULL && a < s->dim; a++) {
      g->velocity[i * s->dim + a] += s->velocity[e * s->dim + a] * share;
    }
  }
}

static void spread_equation(const sct_slope *s, int64_t r, int64_t i, double w, const double *phi,
                            sct_data *g) {
  if (g->source != NULL) g->source[i] -= w;
  if (g->reaction != NULL) g->reaction[i] += w * phi[i];
  if (g->diffusivity != NULL || g->velocity != NULL) spread(s, r, i, w, phi, g);
}

static void spread_condition(int64_t i, double w, const double *phi, sct_data *g) {
  if (g->value != NULL) g->value[i] -= w;
  if (g->coefficient != NULL) g->coefficient[i] += w * phi[i];
}

/* Dirichlet values, by way of the coupling. */
static void spread_coupling(const sct_csr *coupling, int64_t r, double w, double *value) {
  for (int64_t e = coupling->start[r]; e < coupling->start[r + 1]; e++) {
    value[coupling->column[e]] += w * coupling->value[e];
  }
}

void sct_slope_apply_transposed(const sct_slope *slope, const sct_system *system, double factor,
                                const double *weight, const double *phi, sct_data *gradient) {
  for (int64_t row = 0; row < system->unknowns; row++) {
    const int64_t i = system->point_of[row];
    const double w = factor * weight[row];
    if (system->is_equation[row]) spread_equation(slope, row, i, w, phi, gradient);
    if (!system->is_equation[row]) spread_condition(i, w, phi, gradient);
    if (gradient->value != NULL) spread_coupling(system->coupling, row, w, gradient->value);
  }
}
