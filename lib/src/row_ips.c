/* row_ips.c - ips and ipsn: exact for linear functions on any cloud ([H16] eq. 15-27). */
#include <math.h>

#include "row.h"

/* A pivot below this part of the trace: the neighbours lie on a line or a plane. */
static const double FLAT = 1e-4;

/* Of the ps Laplacian's diagonal, what the ips correction must leave. */
static const double LEAST_DIAGONAL = 0.05;

/* Mean effective diffusivity below which ipsn does not trust its division. */
static const double LEAST_DIFFUSIVITY = 0.3;

void row_moments(const row_job *job, const double *f, double m[SCT_DIM_MAX][SCT_DIM_MAX]) {
  for (int a = 0; a < job->dim; a++) {
    for (int b = 0; b <= a; b++) {
      m[a][b] = m[b][a] = row_sum3(job->n, f, job->room->r[a], job->room->r[b]);
    }
  }
}

/* L of M = L L^T in the lower triangle of m. */
static bool factor(int dim, double m[SCT_DIM_MAX][SCT_DIM_MAX]) {
  double trace = 0;
  for (int a = 0; a < dim; a++) trace += m[a][a];
  for (int a = 0; a < dim; a++) {
    for (int b = 0; b <= a; b++) {
      double s = m[a][b];
      for (int c = 0; c < b; c++) s -= m[a][c] * m[b][c];
      if (a == b && !(s > FLAT * trace)) return false;
      m[a][b] = a == b ? sqrt(s) : s / m[b][b];
    }
  }
  return true;
}

bool row_invert(int dim, double m[SCT_DIM_MAX][SCT_DIM_MAX],
                double inverse[SCT_DIM_MAX][SCT_DIM_MAX]) {
  double l[SCT_DIM_MAX][SCT_DIM_MAX];
  for (int a = 0; a < dim; a++) {
    for (int b = 0; b < dim; b++) l[a][b] = m[a][b];
  }
  if (!factor(dim, l)) return false;
  for (int e = 0; e < dim; e++) { /* columns of the inverse: L L^T v = unit vector e */
    double v[SCT_DIM_MAX];
    for (int a = 0; a < dim; a++) {
      v[a] = a == e;
      for (int b = 0; b < a; b++) v[a] -= l[a][b] * v[b];
      v[a] /= l[a][a];
    }
    for (int a = dim - 1; a >= 0; a--) {
      for (int b = a + 1; b < dim; b++) v[a] -= l[b][a] * v[b];
      v[a] /= l[a][a];
      inverse[a][e] = v[a];
    }
  }
  return true;
}

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
