/* The correction q(phi): gradients of all points first, then the edges of every unknown. */
#include "scatter/limited.h"

#include <math.h>

#include "limited_rows.h"

/* (3): how many times the largest difference to a neighbour a slope may extrapolate. One keeps
 * smooth slopes from their full size where neighbours on that side are near; two hardly ever cuts
 * them off. Any number keeps the bounds. */
static const double REACH = 2;

/* (2): largest l(a, b) / a, (1 + sqrt 2) / 2, at b = (1 + sqrt 2) a. */
static const double STEEPEST = 1.2072;

/* van Albada's mean of two slopes of one sign, in a form that does not overflow */
static double limit(double a, double b) {
  if (!(a > 0 && b > 0) && !(a < 0 && b < 0)) return 0;
  const bool a_is_less = fabs(a) < fabs(b);
  const double less = a_is_less ? a : b, s = less / (a_is_less ? b : a);
  return less * (1 + s) / (1 + s * s);
}

static double clamp(double value, double low, double high) {
  return fmin(fmax(value, low), high);
}

static void gradients_of_block(const sct_limited *l, int64_t block, const double *phi,
                               double *gradient) {
  const limited_rows *rows = &l->gradients[block];
  const int64_t first = block * SCT_POINTS_BLOCK;
  for (int64_t i = first; i < first + SCT_POINTS_BLOCK && i < l->n; i++) {
    double *g = gradient + i * l->dim;
    for (int a = 0; a < l->dim; a++) g[a] = 0;
    for (int64_t e = rows->start[i - first]; e < rows->start[i - first + 1]; e++) {
      const double d = phi[rows->index[e]] - phi[i];
      for (int a = 0; a < l->dim; a++) g[a] += rows->value[e * l->dim + a] * d;
    }
  }
}

/* 2 G . (x_j - x_i) */
static double along(const sct_limited *l, const double *gradient, int64_t i, int64_t j) {
  double sum = 0;
  for (int a = 0; a < l->dim; a++)
    sum += gradient[a] * (l->x[j * l->dim + a] - l->x[i * l->dim + a]);
  return 2 * sum;
}

/* q_i of header, (4), over the edges first .. end-1 */
static double correction_of(const sct_limited *l, const limited_rows *rows, int64_t first,
                            int64_t end, int64_t i, const double *phi, const double *gradient) {
  double least = 0, largest = 0, q = 0;
  for (int64_t e = first; e < end; e++) {
    const double d = phi[rows->index[e]] - phi[i];
    least = fmin(least, d);
    largest = fmax(largest, d);
  }
  for (int64_t e = first; e < end; e++) {
    const int64_t j = rows->index[e];
    const double *edge = rows->value + e * EDGE_WIDTH, k = edge[EDGE_CONVECTION];
    const double d = phi[j] - phi[i], low = -REACH * largest, high = -REACH * least;
    if (k > 0) {
      q -= k * limit(clamp(along(l, gradient + i * l->dim, i, j) - d, low, high), d);
    } else if (k < 0) {
      q += k * limit(along(l, gradient + j * l->dim, i, j) - d, d);
    }
    if (edge[EDGE_NEGATIVE] < 0) q -= edge[EDGE_NEGATIVE] * (d - clamp(d, low, high));
  }
  return q;
}

static void edges_of_block(const sct_system *system, int64_t block, const double *phi,
                           const double *gradient, double *q) {
  const sct_limited *l = system->limited;
  const limited_rows *rows = &l->edges[block];
  const int64_t start = block * SCT_POINTS_BLOCK;
  for (int64_t i = start; i < start + SCT_POINTS_BLOCK && i < l->n; i++) {
    if (system->row_of[i] < 0) continue;
    q[system->row_of[i]] = correction_of(l, rows, rows->start[i - start],
                                         rows->start[i - start + 1], i, phi, gradient);
  }
}

void sct_limited_correction(const sct_system *system, const double *phi, const sct_work *work,
                            double *gradient, double *q) {
  const sct_limited *l = system->limited;
#pragma omp parallel num_threads(sct_work_threads(work)) if (l->blocks > 1)
  {
#pragma omp for schedule(static)
    for (int64_t b = 0; b < l->blocks; b++) gradients_of_block(l, b, phi, gradient);
#pragma omp for schedule(static)
    for (int64_t b = 0; b < l->blocks; b++) edges_of_block(system, b, phi, gradient, q);
  }
}

double sct_limited_reach(const sct_system *system, int64_t row) {
  if (system->limited == NULL) return 0;
  const int64_t i = system->point_of[row], k = i % SCT_POINTS_BLOCK;
  const limited_rows *rows = &system->limited->edges[i / SCT_POINTS_BLOCK];
  double sum = 0;
  for (int64_t e = rows->start[k]; e < rows->start[k + 1]; e++) {
    const double *edge = rows->value + e * EDGE_WIDTH;
    sum += REACH * (STEEPEST * fmax(edge[EDGE_CONVECTION], 0) - edge[EDGE_NEGATIVE]);
  }
  return 2 * sum;
}
