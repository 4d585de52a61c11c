#include "solve_policy.h"

#include <math.h>

enum { SAMPLE = 1000 };

/* Rows whose diagonal exceeds the others by less are not dominated by it: ILU(0) needs more than 15
 * iterations there. */
static const double DOMINATED = 0.98;

/* From here on convection has the say: a cell Peclet number of about 3. */
static const double SKEWED = 0.6;

static double entry(const sct_csr *a, int64_t i, int64_t j) {
  int64_t low = a->start[i], high = a->start[i + 1];
  while (low < high) {
    const int64_t middle = low + (high - low) / 2;
    if (a->column[middle] < j) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return low < a->start[i + 1] && a->column[low] == j ? a->value[low] : 0;
}

/* Adds row i to the sums of both traits. */
static void look_at(const sct_csr *a, int64_t i, double *dominated, double *difference,
                    double *size) {
  const double own = fabs(entry(a, i, i));
  double others = 0;
  for (int64_t k = a->start[i]; k < a->start[i + 1]; k++) {
    const int64_t j = a->column[k];
    if (j == i) continue;
    const double there = a->value[k] / own, back = entry(a, j, i) / fabs(entry(a, j, j));
    others += fabs(a->value[k]);
    *difference += fabs(there - back);
    *size += fabs(there) + fabs(back);
  }
  *dominated += others <= DOMINATED * own;
}

sct_solve_traits sct_solve_traits_of(const sct_csr *a, int dim) {
  const int64_t sample = a->rows < SAMPLE ? a->rows : SAMPLE;
  double dominated = 0, difference = 0, size = 0;
  for (int64_t s = 0; s < sample; s++) {
    look_at(a, s * a->rows / sample, &dominated, &difference, &size);
  }
  return (sct_solve_traits){.dim = dim,
                            .rows = a->rows,
                            .dominance = dominated / (double)sample,
                            .skewness = size > 0 ? difference / size : 0};
}

static bool is_dominated(const sct_solve_traits *t) {
  return t->dominance >= 0.5;
}

bool sct_solve_suits_klu(int64_t rows, int dim) {
  const int64_t small = dim == 3 ? 400 : 1000;
  return rows < small || dim == 1;
}

bool sct_solve_suits_iteration(const sct_solve_traits *t) {
  if (t->dim == 3) return t->rows >= 3000;
  if (t->dim != 2 || t->rows < 20000) return false;
  const bool factors_compete = is_dominated(t) || !(t->skewness < SKEWED);
  return !factors_compete || t->rows >= 100000;
}

bool sct_solve_suits_fallback(int64_t rows, int dim) {
  return rows <= (dim == 3 ? 200000 : 3000000);
}

sct_preconditioner sct_solve_preconditioner(const sct_solve_traits *t) {
  if (is_dominated(t) || (t->dim == 3 && t->rows < 200000)) return SCT_ILU;
  return sct_solve_multigrid(t);
}

sct_preconditioner sct_solve_multigrid(const sct_solve_traits *t) {
  return t->dim == 3 || !(t->skewness < SKEWED) ? SCT_AMG_AGGRESSIVE : SCT_AMG;
}
