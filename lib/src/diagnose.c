#include "scatter/diagnose.h"

#include <math.h>

#include "length.h"
#include "points.h"
#include "stencil_inside.h"

/* ---- a cloud, point by point ---- */

typedef struct {
  const sct_stencil *stencil;
  const sct_diagnosis *to;
} diagnosis_job;

/* Order of the entries of a symmetric tensor: xx, yy, zz, xy, xz, yz. */
static const int ENTRY[SCT_DIM_MAX][6][2] = {
    {{0, 0}},
    {{0, 0}, {1, 1}, {0, 1}},
    {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}},
};

static double norm1(int dim, double m[SCT_DIM_MAX][SCT_DIM_MAX]) {
  double largest = 0;
  for (int b = 0; b < dim; b++) {
    double sum = 0;
    for (int a = 0; a < dim; a++) sum += fabs(m[a][b]);
    largest = fmax(largest, sum);
  }
  return largest;
}

/* T_ab = (1/2) sum l r_a r_b with the local ips weights l = (2d/S_w) f (1 - c . r), c = M^-1 o */
static void tensor(const row_job *job, const double *c, double *to) {
  const sct_room *room = job->room;
  const int dim = job->dim, entries = dim * (dim + 1) / 2;
  double *l = room->laplacian;
  for (int64_t k = 0; k < job->n; k++) {
    double dot = 0;
    for (int a = 0; a < dim; a++) dot += c[a] * room->r[a][k];
    l[k] = dim / job->sum_w * room->f[k] * (1 - dot);
  }
  for (int e = 0; e < entries; e++) {
    const int *ab = ENTRY[dim - 1][e];
    to[e] = row_sum3(job->n, l, room->r[ab[0]], room->r[ab[1]]);
  }
}

static void matrix_part(const row_job *job, const double *o, double *to_tensor,
                        double *to_condition) {
  double m[SCT_DIM_MAX][SCT_DIM_MAX], inverse[SCT_DIM_MAX][SCT_DIM_MAX];
  double c[SCT_DIM_MAX] = {0};
  row_moments(job, job->room->f, m);
  if (!row_invert(job->dim, m, inverse)) {
    if (to_condition != NULL) *to_condition = INFINITY;
    return;
  }
  for (int a = 0; a < job->dim; a++) {
    for (int b = 0; b < job->dim; b++) c[a] += inverse[a][b] * o[b];
  }
  if (to_condition != NULL) *to_condition = norm1(job->dim, m) * norm1(job->dim, inverse);
  if (to_tensor != NULL) tensor(job, c, to_tensor);
}

static sct_status diagnose_point(void *context, int64_t i, sct_room *room, sct_error *err) {
  const diagnosis_job *job = context;
  const sct_diagnosis *to = job->to;
  const int dim = job->stencil->cloud.dim, entries = dim * (dim + 1) / 2;
  const int32_t *index;
  double o[SCT_DIM_MAX] = {0};
  row_job row = {.dim = dim, .room = room};
  (void)err;
  row.n = sct_stencil_gather(job->stencil, i, room, true, &index);
  row.sum_w = row_sum(row.n, room->w);
  const bool alone = !(row.sum_w > 0);
  if (to->neighbours != NULL) to->neighbours[i] = (int32_t)row.n;
  if (to->number_density != NULL) to->number_density[i] = row.sum_w;
  for (int a = 0; a < dim; a++) o[a] = row_sum2(row.n, room->f, room->r[a]);
  for (int a = 0; to->artificial_velocity != NULL && a < dim; a++) {
    to->artificial_velocity[i * dim + a] = alone ? 0 : 2 * dim * o[a] / row.sum_w;
  }
  double *t = to->effective_diffusivity;
  double *condition = to->condition == NULL ? NULL : to->condition + i;
  if (t != NULL) t += i * entries;
  for (int e = 0; t != NULL && e < entries; e++) t[e] = 0;
  if (t != NULL || condition != NULL) matrix_part(&row, o, t, condition);
  return SCT_OK;
}

sct_status sct_diagnose(const sct_stencil *stencil, const sct_work *work,
                        const sct_diagnosis *diagnosis, sct_error *err) {
  diagnosis_job job = {stencil, diagnosis};
  return sct_points_run(stencil, 0, stencil->cloud.n, work, diagnose_point, &job, err);
}

/* ---- fields ---- */

sct_range sct_range_of(const double *value, int64_t n, int64_t stride, const uint8_t *mask) {
  sct_range range = {.min = INFINITY, .max = -INFINITY};
  double sum = 0, squares = 0;
  for (int64_t i = 0; i < n; i++) {
    if (mask != NULL && !mask[i]) continue;
    const double v = value[i * stride];
    range.min = fmin(range.min, v);
    range.max = fmax(range.max, v);
    sum += v;
    squares += v * v;
    range.points++;
  }
  if (range.points == 0) range.min = range.max = NAN;
  range.mean = sum / (double)range.points;
  range.rms = sqrt(squares / (double)range.points);
  return range;
}

/* |e| at point i. */
static double distance_of(const double *value, const double *exact, int64_t i, int components) {
  double e[SCT_DIM_MAX];
  for (int a = 0; a < components; a++) e[a] = value[i * components + a] - exact[i * components + a];
  return sct_length(e, components);
}

/* The norms by squares, of errors and exact values scaled by `scale` and `exact_scale`. */
static void mean_squares(const double *value, const double *exact, int64_t n, int components,
                         const uint8_t *mask, double scale, double exact_scale, sct_norms *norms) {
  double squares = 0, exact_squares = 0;
  for (int64_t i = 0; i < n; i++) {
    if (mask != NULL && !mask[i]) continue;
    const double size = scale * distance_of(value, exact, i, components);
    const double of = exact_scale * sct_length(exact + i * components, components);
    squares += size * size;
    exact_squares += of * of;
  }
  norms->l2 = sqrt(squares / (double)norms->points) / scale;
  norms->l2_relative =
      exact_squares > 0 ? sqrt(squares / exact_squares) / scale * exact_scale : NAN;
}

sct_norms sct_norms_of(const double *value, const double *exact, int64_t n, int components,
                       const uint8_t *mask) {
  sct_norms norms = {0};
  double sum = 0, exact_linf = 0;
  for (int64_t i = 0; i < n; i++) {
    const double size = distance_of(value, exact, i, components);
    norms.linf_all = size > norms.linf_all || isnan(size) ? size : norms.linf_all;
    if (mask != NULL && !mask[i]) continue;
    norms.linf = size > norms.linf || isnan(size) ? size : norms.linf;
    exact_linf = fmax(exact_linf, sct_length(exact + i * components, components));
    norms.points++;
    sum += size;
  }
  norms.l1 = sum / (double)norms.points;
  mean_squares(value, exact, n, components, mask, sct_scale_of(norms.linf),
               sct_scale_of(exact_linf), &norms);
  if (norms.points == 0) norms.linf = NAN;
  return norms;
}
