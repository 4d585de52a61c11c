#include "estimate.h"

#include <math.h>

/* Of a worker that has done nothing. */
static const double BASE = 16e6;

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
  const double m = estimate_neighbours(dim, op->radius);
  return (int64_t)((double)n * (300 + 40 * dim + (12 + 8 * (dim + 1)) * m));
}

int64_t estimate_system(int dim, int64_t n, const sct_operator *op) {
  const double m = estimate_neighbours(dim, op->radius), points = (double)n;
  const double growth = dim == 3 ? cbrt(points) : dim == 2 ? log2(points + 2) : 1;
  return (int64_t)(points * m * (30 + 8 * growth));
}

/* Per entry the matrix, its scaled copy and the preconditioner's; per row vectors. */
int64_t estimate_iteration(int dim, int64_t n, const sct_operator *op) {
  return (int64_t)((double)n * (250 + 32 * estimate_neighbours(dim, op->radius)));
}

int64_t estimate_run(const task *t, const performance *f) {
  const double own = f->process->memory ? (double)f->process->memory(t, f->state) : 0;
  return (int64_t)(BASE + own);
}
