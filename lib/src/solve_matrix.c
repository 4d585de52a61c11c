#include "solve_matrix.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "alloc.h"

/* The pattern of A by columns: entries of column j go to start[j] and on, rows ascending. */
static void transpose(const sct_csr *a, sct_solve_matrix *m) {
  const int entries = (int)sct_csr_entries(a);
  memset(m->start, 0, (size_t)(m->n + 1) * sizeof *m->start);
  for (int k = 0; k < entries; k++) m->start[a->column[k] + 1]++;
  for (int j = 0; j < m->n; j++) m->start[j + 1] += m->start[j];
  for (int i = 0; i < m->n; i++) {
    for (int k = (int)a->start[i]; k < a->start[i + 1]; k++) {
      const int p = m->start[a->column[k]]++; /* start[j] runs to the end of column j ... */
      m->row[p] = i;
      m->value[p] = 1;
      m->from[p] = k;
    }
  }
  memmove(m->start + 1, m->start, (size_t)m->n * sizeof *m->start); /* ... the start of j + 1 */
  m->start[0] = 0;
}

sct_status sct_solve_matrix_pattern(sct_solve_matrix *m, const sct_csr *a, sct_error *err) {
  const int64_t entries = sct_csr_entries(a);
  const struct {
    void *array;
    int64_t n;
    size_t size;
  } arrays[] = {
      {&m->start, a->rows + 1, sizeof(int)}, {&m->row, entries, sizeof(int)},
      {&m->value, entries, sizeof(double)},  {&m->from, entries, sizeof(int)},
      {&m->scale, a->rows, sizeof(double)},
  };
  for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++) {
    sct_status status = sct_alloc(arrays[k].array, arrays[k].n, arrays[k].size, err);
    if (status != SCT_OK) return status;
  }
  m->n = (int)a->rows;
  transpose(a, m);
  return SCT_OK;
}

/* D: brings the largest entry of row i to [1/2, 1). */
static sct_status find_scale(const sct_csr *a, int64_t i, double *scale, sct_error *err) {
  double largest = 0;
  bool finite = true;
  for (int64_t k = a->start[i]; k < a->start[i + 1]; k++) {
    largest = fmax(largest, fabs(a->value[k]));
    finite = finite && isfinite(a->value[k]);
  }
  if (!finite) {
    return sct_fail(err, SCT_E_NOT_FINITE, -1, "row %lld of the matrix is not finite",
                    (long long)i);
  }
  if (largest < DBL_MIN) {
    return sct_fail(err, SCT_E_SINGULAR, -1, "row %lld of %lld of the matrix is zero", (long long)i,
                    (long long)a->rows);
  }
  int exponent;
  frexp(largest, &exponent);
  *scale = ldexp(1, -exponent);
  return SCT_OK;
}

/* Values of D A; false if an entry of A is not where it was analysed. */
static bool copy_values(sct_solve_matrix *m, const sct_csr *a) {
  for (int j = 0; j < m->n; j++) {
    for (int p = m->start[j]; p < m->start[j + 1]; p++) {
      const int i = m->row[p], k = m->from[p];
      if (a->column[k] != j || k < a->start[i] || k >= a->start[i + 1]) return false;
      m->value[p] = m->scale[i] * a->value[k];
    }
  }
  return true;
}

sct_status sct_solve_matrix_values(sct_solve_matrix *m, const sct_csr *a, sct_error *err) {
  const int n = m->n;
  bool same = a->rows == n && a->columns == n && sct_csr_entries(a) == m->start[n];
  for (int i = 0; same && i < n; i++) {
    sct_status status = find_scale(a, i, &m->scale[i], err);
    if (status != SCT_OK) return status;
  }
  if (same && copy_values(m, a)) return SCT_OK;
  return sct_fail(err, SCT_E_ARGUMENT, -1, "the matrix has not the pattern that was analysed");
}

void sct_solve_matrix_clear(sct_solve_matrix *m) {
  sct_release(&m->start);
  sct_release(&m->row);
  sct_release(&m->value);
  sct_release(&m->from);
  sct_release(&m->scale);
}
