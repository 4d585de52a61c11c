#include "estimate.h"

#include <math.h>

#include "cloud_input.h"

/* Of a worker that has done nothing; of the iterative solvers' package. */
static const int64_t BASE = 19000000, PACKAGE = 30000000;

double estimate_neighbours(int dim, double radius) {
  const int reach = (int)radius;
  double count = 0;
  for (int x = -reach; x <= reach; x++) {
    for (int y = dim > 1 ? -reach : 0; y <= (dim > 1 ? reach : 0); y++) {
      for (int z = dim > 2 ? -reach : 0; z <= (dim > 2 ? reach : 0); z++) {
        const double r2 = (double)(x * x + y * y + z * z);
        count += r2 > 0 && r2 < radius * radius;
      }
    }
  }
  return count;
}

int64_t estimate_points(int dim, int64_t n, const sct_operator *op) {
  return (int64_t)((double)n * (250 + 14 * estimate_neighbours(dim, op->radius)));
}

/* Numbers of the acceleration by point; coordinates, gradients and edges, which grow by halves. */
int64_t estimate_limited(int dim, int64_t n, const sct_operator *op) {
  enum { ITERATION = 33 * 8, GRADIENT = 12, EDGES = 30 };
  const double m = estimate_neighbours(dim, op->radius);
  if (op->upwind != SCT_UPWIND_LIMITED) return 0;
  return (int64_t)((double)n * (ITERATION + 16 * dim + m * (GRADIENT * (dim + 1) + EDGES)));
}

int64_t estimate_matrix(int dim, int64_t n, const sct_operator *op) {
  return (int64_t)((double)n * (40 + 22 * estimate_neighbours(dim, op->radius)));
}

int64_t estimate_iteration(int dim, int64_t n, const sct_operator *op) {
  return PACKAGE + (int64_t)((double)n * (420 + 8 * estimate_neighbours(dim, op->radius)));
}

int64_t estimate_solver(int dim, int64_t n, const sct_operator *op,
                        const sct_solve_options *options) {
  return sct_solver_iterates(options, n) ? estimate_iteration(dim, n, op)
                                         : estimate_factors(dim, n, op);
}

/* Bytes per point by dimension; a denser stencil costs less than in proportion. */
int64_t estimate_factors(int dim, int64_t count, const sct_operator *op) {
  const double m = estimate_neighbours(dim, op->radius), n = (double)count;
  const double per_point[] = {0, 200, pow(m, 0.8) * fmax(100, 44 * log2(n + 1) - 300),
                              pow(m, 0.57) * (720 + 1.12 * pow(n, 2.0 / 3))};
  return (int64_t)(n * per_point[dim]);
}

int64_t estimate_run(const task *t, const performance *f) {
  return BASE + (f->process->memory && f->state ? f->process->memory(t, f->state) : 0);
}

int64_t estimate_shared(const task *t, int64_t run, int64_t processes) {
  /* bytes of a rank itself and of a point of the whole on each; quarters of a part with its halo */
  enum { RANK = 60000000, FIELDS = 160, HALO = 5 };
  const int64_t n = t->cloud ? t->cloud->cloud.n : 0;
  return processes < 2 ? run : processes * (RANK + FIELDS * n) + run / 4 * HALO;
}
