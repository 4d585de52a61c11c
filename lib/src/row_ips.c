/* row_ips.c - ips and ipsn: exact for linear functions on any cloud ([H16] eq. 15-27). */
#include "row.h"

/* Of the ps Laplacian's diagonal, what the ips correction must leave. */
static const double LEAST_DIAGONAL = 0.05;

/* Mean effective diffusivity below which ipsn does not trust its division. */
static const double LEAST_DIFFUSIVITY = 0.3;

/* to[k] = f_k (c . r_k) */
static void weighted_direction(const row_job *job, const double *f, const double *c, double *to) {
  const int64_t n = job->n;
  for (int a = 0; a < job->dim; a++) {
    const double *r = job->room->r[a];
    const double ca = c[a];
    if (a == 0) {
      for (int64_t k = 0; k < n; k++) to[k] = ca * r[k];
    } else {
      for (int64_t k = 0; k < n; k++) to[k] += ca * r[k];
    }
  }
  for (int64_t k = 0; k < n; k++) to[k] *= f[k];
}

/* g_a = f_k (M^-1)_a . r_k for a given weight f and its M^-1           [H16] eq. 19 */
static void linear_gradient(const row_job *job, const double *f,
                            double inverse[SCT_DIM_MAX][SCT_DIM_MAX]) {
  for (int a = 0; a < job->dim; a++) {
    weighted_direction(job, f, inverse[a], job->room->gradient + a * job->n);
  }
}

row_verdict row_gradient_linear(row_job *job) {
  double m[SCT_DIM_MAX][SCT_DIM_MAX], inverse[SCT_DIM_MAX][SCT_DIM_MAX];
  if (row_is_limited(job)) return row_gradient_balanced(job);
  if (job->n < job->dim) return ROW_TOO_FEW;
  const double *f = job->room->f;
  if (job->velocity != NULL) {
    row_upwind_weight(job, job->room->scratch);
    f = job->room->scratch;
  }
  row_moments(job, f, m);
  if (!row_invert(job->dim, m, inverse)) return ROW_FLAT;
  linear_gradient(job, f, inverse);
  return ROW_ACCEPTED;
}

row_verdict row_normal_linear(row_job *job) {
  double m[SCT_DIM_MAX][SCT_DIM_MAX], inverse[SCT_DIM_MAX][SCT_DIM_MAX], c[SCT_DIM_MAX] = {0};
  if (job->n < job->dim) return ROW_TOO_FEW;
  row_moments(job, job->room->f, m);
  if (!row_invert(job->dim, m, inverse)) return ROW_FLAT;
  for (int a = 0; a < job->dim; a++) {
    for (int b = 0; b < job->dim; b++) c[a] += inverse[a][b] * job->request->normal[b];
  }
  weighted_direction(job, job->room->f, c, job->room->laplacian);
  return ROW_ACCEPTED;
}

/* l = (2 d / S_w) f_k (1 - o . M^-1 r_k)                               [H16] eq. 20 */
static row_verdict ips_laplacian(const row_job *job, double inverse[SCT_DIM_MAX][SCT_DIM_MAX]) {
  sct_room *room = job->room;
  double o[SCT_DIM_MAX], c[SCT_DIM_MAX] = {0};
  for (int a = 0; a < job->dim; a++) o[a] = row_sum2(job->n, room->f, room->r[a]);
  for (int a = 0; a < job->dim; a++) {
    for (int b = 0; b < job->dim; b++) c[a] += inverse[a][b] * o[b];
  }
  const double factor_w = 2 * job->dim / job->sum_w;
  double *l = room->laplacian;
  weighted_direction(job, room->f, c, l);
  for (int64_t k = 0; k < job->n; k++) l[k] = factor_w * (room->f[k] - l[k]);
  const double diagonal = row_sum(job->n, l), ps = factor_w * row_sum(job->n, room->f);
  return diagonal > LEAST_DIAGONAL * ps ? ROW_ACCEPTED : ROW_NO_DIFFUSION;
}

row_verdict row_ips(row_job *job) {
  double m[SCT_DIM_MAX][SCT_DIM_MAX], inverse[SCT_DIM_MAX][SCT_DIM_MAX];
  if (job->want & SCT_ROW_NORMAL) return row_normal_linear(job);
  if (job->n < job->dim + ((job->want & SCT_ROW_LAPLACIAN) != 0)) return ROW_TOO_FEW;
  if ((job->want & SCT_ROW_GRADIENT) && job->velocity != NULL) {
    const row_verdict verdict = row_gradient_linear(job);
    if (verdict != ROW_ACCEPTED) return verdict;
  }
  row_moments(job, job->room->f, m);
  if (!row_invert(job->dim, m, inverse)) return ROW_FLAT;
  if ((job->want & SCT_ROW_GRADIENT) && job->velocity == NULL) {
    linear_gradient(job, job->room->f, inverse);
  }
  return job->want & SCT_ROW_LAPLACIAN ? ips_laplacian(job, inverse) : ROW_ACCEPTED;
}

/* Divides by the mean of the effective diffusivity, trace T / d with T_aa = (1/2) sum l r_a^2. */
row_verdict row_ipsn(row_job *job) {
  const row_verdict verdict = row_ips(job);
  if (verdict != ROW_ACCEPTED || !(job->want & SCT_ROW_LAPLACIAN)) return verdict;
  double *l = job->room->laplacian;
  const double mean = row_sum2(job->n, l, job->room->r2) / (2 * job->dim);
  if (!(mean > LEAST_DIFFUSIVITY)) return ROW_NO_DIFFUSION;
  for (int64_t k = 0; k < job->n; k++) l[k] /= mean;
  return ROW_ACCEPTED;
}
