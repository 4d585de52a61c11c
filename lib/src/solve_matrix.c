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
  m->index = m->row;
}

sct_status sct_solve_matrix_pattern(sct_solve_matrix *m, const sct_csr *a, bool by_rows,
                                    sct_error *err) {
  const int64_t entries = sct_csr_entries(a);
  const struct {
    void *array;
    int64_t n;
    size_t size;
  } arrays[] = {
      {&m->start, a->rows + 1, sizeof(int)}, {&m->value, entries, sizeof(double)},
      {&m->scale, a->rows, sizeof(double)},  {&m->row, entries, sizeof(int)},
      {&m->from, entries, sizeof(int)},
  };
  for (int k = 0; k < (by_rows ? 3 : 5); k++) {
    sct_status status = sct_alloc(arrays[k].array, arrays[k].n, arrays[k].size, err);
    if (status != SCT_OK) return status;
  }
  m->n = (int)a->rows;
  m->by_rows = by_rows;
  if (!by_rows) transpose(a, m);
  for (int i = 0; by_rows && i <= m->n; i++) m->start[i] = (int)a->start[i];
  return SCT_OK;
}

/* The largest entry of row i, which is not zero, and the one on the diagonal. */
static sct_status measure_row(const sct_csr *a, int64_t i, double *most, double *diagonal,
                              sct_error *err) {
  double largest = 0;
  bool finite = true;
  *diagonal = 0;
  for (int64_t k = a->start[i]; k < a->start[i + 1]; k++) {
    largest = fmax(largest, fabs(a->value[k]));
    finite = finite && isfinite(a->value[k]);
    if (a->column[k] == i) *diagonal = a->value[k];
  }
  if (!finite) {
    return sct_fail(err, SCT_E_NOT_FINITE, -1, "row %lld of the matrix is not finite",
                    (long long)i);
  }
  if (largest < DBL_MIN) {
    return sct_fail(err, SCT_E_SINGULAR, -1, "row %lld of %lld of the matrix is zero", (long long)i,
                    (long long)a->rows);
  }
  *most = largest;
  return SCT_OK;
}

/* A diagonal that is hardly there does not count. */
double sct_solve_scale(double most, double diagonal, bool is_equation) {
  const double size = fabs(diagonal) > 0.1 * most ? diagonal : most;
  return (is_equation ? 1 : 0.25) / size;
}

static double scale_by_power(double most) {
  int exponent;
  frexp(most, &exponent);
  return ldexp(1, -exponent);
}

static sct_status find_scales(sct_solve_matrix *m, const sct_csr *a, const uint8_t *is_equation,
                              sct_error *err) {
  for (int i = 0; i < m->n; i++) {
    double most = 1, diagonal = 1;
    sct_status status = measure_row(a, i, &most, &diagonal, err);
    if (status != SCT_OK) return status;
    m->scale[i] = m->by_rows
                      ? sct_solve_scale(most, diagonal, is_equation == NULL || is_equation[i])
                      : scale_by_power(most);
  }
  return SCT_OK;
}

/* Values of D A by columns; false if an entry of A is not where it was analysed. */
static bool copy_columns(sct_solve_matrix *m, const sct_csr *a) {
  for (int j = 0; j < m->n; j++) {
    for (int p = m->start[j]; p < m->start[j + 1]; p++) {
      const int i = m->row[p], k = m->from[p];
      if (a->column[k] != j || k < a->start[i] || k >= a->start[i + 1]) return false;
      m->value[p] = m->scale[i] * a->value[k];
    }
  }
  return true;
}

/* The same by rows. */
static bool copy_rows(sct_solve_matrix *m, const sct_csr *a) {
  for (int i = 0; i < m->n; i++) {
    int64_t last = -1;
    if (a->start[i] != m->start[i]) return false;
    for (int k = m->start[i]; k < m->start[i + 1]; k++) {
      if (a->column[k] <= last || a->column[k] >= m->n) return false;
      last = a->column[k];
      m->value[k] = m->scale[i] * a->value[k];
    }
  }
  m->index = a->column;
  m->source = a;
  return true;
}

sct_status sct_solve_matrix_values(sct_solve_matrix *m, const sct_csr *a,
                                   const uint8_t *is_equation, sct_error *err) {
  const int n = m->n;
  const bool as_large = a->rows == n && a->columns == n && sct_csr_entries(a) == m->start[n];
  if (as_large) {
    sct_status status = find_scales(m, a, is_equation, err);
    if (status != SCT_OK) return status;
  }
  if (as_large && (m->by_rows ? copy_rows : copy_columns)(m, a)) return SCT_OK;
  return sct_fail(err, SCT_E_ARGUMENT, -1, "the matrix has not the pattern that was analysed");
}

void sct_solve_matrix_clear(sct_solve_matrix *m) {
  sct_release(&m->start);
  sct_release(&m->row);
  sct_release(&m->value);
  sct_release(&m->from);
  sct_release(&m->scale);
  m->index = NULL;
}
