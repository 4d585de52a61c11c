/* row_pair.c - mps and ps: weights that depend on one pair only. */
#include "row.h"

/* The neighbours must span the space, or a derivative is silently left out. */
static bool spans(const row_job *job) {
  double m[SCT_DIM_MAX][SCT_DIM_MAX], inverse[SCT_DIM_MAX][SCT_DIM_MAX];
  row_moments(job, job->room->f, m);
  return row_invert(job->dim, m, inverse);
}

/* g = (d / S_w) W r_j / r^2                                        [H11] eq. 5, [H16] eq. 1 */
static row_verdict pair_gradient(row_job *job) {
  if (row_is_limited(job) || (job->want & SCT_ROW_LINEAR)) return row_gradient_linear(job);
  sct_room *room = job->room;
  const double *f = room->f;
  if (job->velocity != NULL) {
    row_upwind_weight(job, room->scratch);
    f = room->scratch;
  }
  const double factor = job->dim / job->sum_w;
  for (int a = 0; a < job->dim; a++) {
    const double *r = room->r[a];
    double *g = room->gradient + a * job->n;
    for (int64_t k = 0; k < job->n; k++) g[k] = factor * f[k] * r[k];
  }
  return ROW_ACCEPTED;
}

static void scaled_copy(int64_t n, double factor, const double *from, double *to) {
  for (int64_t k = 0; k < n; k++) to[k] = factor * from[k];
}

static row_verdict pair_row(row_job *job, double factor, const double *weight) {
  if (job->want & SCT_ROW_NORMAL) return row_normal_linear(job);
  if (job->n < job->dim + ((job->want & SCT_ROW_LAPLACIAN) != 0)) return ROW_TOO_FEW;
  if (!spans(job)) return ROW_FLAT;
  if (job->want & SCT_ROW_LAPLACIAN) scaled_copy(job->n, factor, weight, job->room->laplacian);
  return job->want & SCT_ROW_GRADIENT ? pair_gradient(job) : ROW_ACCEPTED;
}

row_verdict row_mps(row_job *job) { /* l = 2 d w / (lambda S_w)        [H11] eq. 7 */
  return pair_row(job, 2 * job->dim / job->sum_w_r2, job->room->w);
}

row_verdict row_ps(row_job *job) { /* l = (2 d / S_w) w / r^2          [H16] eq. 2 */
  return pair_row(job, 2 * job->dim / job->sum_w, job->room->f);
}
