/* row_moments.c - sums over the neighbours of a point, and the matrix M that they make. */
#include <math.h>

#include "row.h"

/* A pivot below this part of the trace: the neighbours lie on a line or a plane. */
static const double FLAT = 1e-4;

double row_sum(int64_t n, const double *a) {
  double sum = 0;
#pragma omp simd reduction(+ : sum)
  for (int64_t k = 0; k < n; k++) sum += a[k];
  return sum;
}

double row_sum2(int64_t n, const double *a, const double *b) {
  double sum = 0;
#pragma omp simd reduction(+ : sum)
  for (int64_t k = 0; k < n; k++) sum += a[k] * b[k];
  return sum;
}

double row_sum3(int64_t n, const double *a, const double *b, const double *c) {
  double sum = 0;
#pragma omp simd reduction(+ : sum)
  for (int64_t k = 0; k < n; k++) sum += a[k] * b[k] * c[k];
  return sum;
}

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
