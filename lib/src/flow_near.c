/* flow_near.c - the sites around a place. The inner loop of a flow. */
#include <math.h>

#include "flow_inside.h"

/* First and last cell of an axis that a support around x reaches. */
static void reach(const flow_axis *a, int64_t i, double x, double support, int64_t *first,
                  int64_t *last) {
  int64_t low = i, high = i;
  while (low > 0 && a->edge[low] > x - support) low--;
  while (high + 1 < a->n && a->edge[high + 1] < x + support) high++;
  *first = low;
  *last = high;
}

/* Where walls are mirrors, their points serve only the transfer to faces. */
static bool counts(int32_t particle) {
  return particle != SITE_WALL && particle != SITE_WALL_NO_FLUX;
}

bool flow_near_gather(const sct_flow *f, int64_t i, int64_t j, const double x[2], double support,
                      flow_near *near) {
  const flow_sites *s = &f->sites;
  const double square = support * support, own = 1e-20 * square;
  const bool mirrors = f->options.walls == SCT_FLOW_WALL_MIRROR;
  int64_t i0, i1, j0, j1;
  int n = 0;
  reach(&f->mesh.axis[0], i, x[0], support, &i0, &i1);
  reach(&f->mesh.axis[1], j, x[1], support, &j0, &j1);
  for (int64_t row = j0; row <= j1; row++) {
    const int64_t first = s->start[flow_cell(&f->mesh, i0, row)];
    const int64_t end = s->start[flow_cell(&f->mesh, i1, row) + 1];
    if (n + (end - first) > FLOW_NEAR_MOST) return false;
    for (int64_t k = first; k < end; k++) {
      const double dx = s->x[0][k] - x[0], dy = s->x[1][k] - x[1], r2 = dx * dx + dy * dy;
      near->x[0][n] = dx;
      near->x[1][n] = dy;
      near->r2[n] = r2;
      near->site[n] = (int32_t)k;
      n += (r2 < square) & (r2 > own) & (!mirrors || counts(s->particle[k]));
    }
  }
  near->n = n;
  return true;
}

double flow_near_weigh(const sct_flow *f, double support, flow_near *near) {
  const double inverse = 1 / support;
  double sum = 0;
  for (int k = 0; k < near->n; k++) near->q[k] = sqrt(near->r2[k]) * inverse;
  f->options.op.kernel->fill(near->n, near->q, near->w);
  for (int k = 0; k < near->n; k++) near->f[k] = near->w[k] / near->r2[k];
#pragma omp simd reduction(+ : sum)
  for (int k = 0; k < near->n; k++) sum += near->w[k];
  return sum;
}
