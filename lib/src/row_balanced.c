/* row_balanced.c - the gradient of a linear fit whose constant is free: its weights sum to zero. */
#include "row.h"

/* c = sum f r / sum f, and M about it: M - (sum f) c c^T */
static void centre_moments(const row_job *job, double c[SCT_DIM_MAX],
                           double m[SCT_DIM_MAX][SCT_DIM_MAX]) {
  const double *f = job->room->f, sum = row_sum(job->n, f);
  for (int a = 0; a < job->dim; a++) c[a] = row_sum2(job->n, f, job->room->r[a]) / sum;
  for (int a = 0; a < job->dim; a++) {
    for (int b = 0; b < job->dim; b++) m[a][b] -= sum * c[a] * c[b];
  }
}

/* g_k = f_k row . (r_k - c) */
static void balanced_component(const row_job *job, const double row[SCT_DIM_MAX],
                               const double c[SCT_DIM_MAX], double *g) {
  double shift = 0;
  for (int a = 0; a < job->dim; a++) shift += row[a] * c[a];
  for (int64_t k = 0; k < job->n; k++) {
    double dot = 0;
    for (int a = 0; a < job->dim; a++) dot += row[a] * job->room->r[a][k];
    g[k] = job->room->f[k] * (dot - shift);
  }
}

/* As many neighbours as dimensions span the space from the point, but not from their own centre:
 * there the constant is that of the point. */
row_verdict row_gradient_balanced(row_job *job) {
  double m[SCT_DIM_MAX][SCT_DIM_MAX], inverse[SCT_DIM_MAX][SCT_DIM_MAX], c[SCT_DIM_MAX];
  if (job->n < job->dim) return ROW_TOO_FEW;
  row_moments(job, job->room->f, m);
  centre_moments(job, c, m);
  if (!row_invert(job->dim, m, inverse)) {
    row_moments(job, job->room->f, m);
    if (!row_invert(job->dim, m, inverse)) return ROW_FLAT;
    for (int a = 0; a < job->dim; a++) c[a] = 0;
  }
  for (int a = 0; a < job->dim; a++) {
    balanced_component(job, inverse[a], c, job->room->gradient + a * job->n);
  }
  return ROW_ACCEPTED;
}
