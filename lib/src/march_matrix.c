#include "march_matrix.h"

#include <string.h>

#include "alloc.h"

struct sct_march_matrix {
  int64_t rows;
  int32_t *unknown;     /* [rows] unknown of a row */
  int32_t *row_of;      /* [unknowns] its inverse, -1: not covered */
  double *rhs, *x;      /* [rows] */
  uint8_t *is_equation; /* [rows] */
  sct_csr *matrix;
  sct_solver *solver;
  int64_t factorisations;
};

static void choose_rows(sct_march_matrix *m, const sct_system *system, bool conditions_only) {
  for (int64_t i = 0; i < system->unknowns; i++) {
    m->row_of[i] = -1;
    if (conditions_only && system->is_equation[i]) continue;
    m->row_of[i] = (int32_t)m->rows;
    m->is_equation[m->rows] = system->is_equation[i];
    m->unknown[m->rows++] = (int32_t)i;
  }
}

sct_status sct_march_matrix_new(const sct_system *system, bool conditions_only,
                                sct_march_matrix **matrix, sct_error *err) {
  sct_march_matrix *m = NULL;
  sct_status status = sct_alloc_zero(&m, 1, sizeof *m, err);
  if (status != SCT_OK) goto done;
  status = sct_alloc(&m->unknown, system->unknowns, sizeof *m->unknown, err);
  if (status != SCT_OK) goto done;
  status = sct_alloc(&m->row_of, system->unknowns, sizeof *m->row_of, err);
  if (status != SCT_OK) goto done;
  status = sct_alloc(&m->is_equation, system->unknowns, sizeof *m->is_equation, err);
  if (status != SCT_OK) goto done;
  choose_rows(m, system, conditions_only);
  status = sct_alloc(&m->rhs, m->rows, sizeof *m->rhs, err);
  if (status != SCT_OK) goto done;
  status = sct_alloc(&m->x, m->rows, sizeof *m->x, err);
done:
  if (status != SCT_OK) sct_march_matrix_free(&m);
  *matrix = m;
  return status;
}

void sct_march_matrix_free(sct_march_matrix **matrix) {
  sct_march_matrix *m = *matrix;
  if (m == NULL) return;
  sct_release(&m->unknown);
  sct_release(&m->row_of);
  sct_release(&m->is_equation);
  sct_release(&m->rhs);
  sct_release(&m->x);
  sct_csr_free(&m->matrix);
  sct_solver_free(&m->solver);
  sct_release(matrix);
}

/* Appends row r; an equation row gets a diagonal entry even where A has none. */
static void append_row(const sct_march_matrix *m, const sct_system *system, double shift, int64_t r,
                       sct_csr *out) {
  const sct_csr *a = system->matrix;
  const int64_t i = m->unknown[r];
  const bool equation = system->is_equation[i] != 0;
  const double factor = equation ? shift : 1;
  bool placed = !equation;
  int64_t k = out->start[r];
  for (int64_t p = a->start[i]; p < a->start[i + 1]; p++) {
    const int32_t column = m->row_of[a->column[p]];
    if (column < 0) continue;
    if (!placed && column >= r) {
      placed = true;
      if (column > r) {
        out->column[k] = (int32_t)r;
        out->value[k++] = 1;
      }
    }
    out->column[k] = column;
    out->value[k++] = factor * a->value[p] + (equation && column == r ? 1 : 0);
  }
  if (!placed) {
    out->column[k] = (int32_t)r;
    out->value[k++] = 1;
  }
  out->start[r + 1] = k;
}

static sct_status form(const sct_march_matrix *m, const sct_system *system, double shift,
                       sct_csr **out, sct_error *err) {
  int64_t room = m->rows;
  for (int64_t r = 0; r < m->rows; r++) {
    room += system->matrix->start[m->unknown[r] + 1] - system->matrix->start[m->unknown[r]];
  }
  sct_status status = sct_csr_new(m->rows, m->rows, room, out, err);
  for (int64_t r = 0; status == SCT_OK && r < m->rows; r++) append_row(m, system, shift, r, *out);
  return status;
}

static bool same_pattern(const sct_csr *a, const sct_csr *b) {
  return b != NULL && a->rows == b->rows &&
         memcmp(a->start, b->start, (size_t)(a->rows + 1) * sizeof *a->start) == 0 &&
         memcmp(a->column, b->column, (size_t)sct_csr_entries(a) * sizeof *a->column) == 0;
}

sct_status sct_march_matrix_factor(sct_march_matrix *m, const sct_system *system, double shift,
                                   const sct_solve_options *options, sct_error *err) {
  if (m->rows == 0) return SCT_OK;
  sct_solve_options of_rows = *options;
  const bool all = m->rows == system->unknowns;
  if (!all && options->dim > 1) of_rows.dim--; /* a boundary */
  of_rows.is_equation = all ? m->is_equation : NULL;
  of_rows.guess = all;
  sct_csr *next = NULL;
  sct_status status = form(m, system, shift, &next, err);
  if (status != SCT_OK) return status;
  if (!same_pattern(next, m->matrix)) sct_solver_free(&m->solver);
  sct_csr_free(&m->matrix);
  m->matrix = next;
  if (m->solver == NULL) status = sct_solver_analyse(next, &of_rows, &m->solver, err);
  if (status == SCT_OK) status = sct_solver_factor(m->solver, next, err);
  if (status == SCT_OK) m->factorisations++;
  return status;
}

/* What is left of row i's right-hand side when the unknowns that are not covered are known. */
static double remainder_of(const sct_march_matrix *m, const sct_csr *a, int64_t i, double rhs,
                           const double *y) {
  for (int64_t k = a->start[i]; k < a->start[i + 1]; k++) {
    if (m->row_of[a->column[k]] < 0) rhs -= a->value[k] * y[a->column[k]];
  }
  return rhs;
}

sct_status sct_march_matrix_solve(sct_march_matrix *m, const sct_system *system, const double *rhs,
                                  double *y, sct_error *err) {
  if (m->rows == system->unknowns && m->rows > 0) {
    return sct_solver_solve(m->solver, rhs, false, y, err);
  }
  memcpy(y, rhs, (size_t)system->unknowns * sizeof *y);
  if (m->rows == 0) return SCT_OK;
  for (int64_t r = 0; r < m->rows; r++) {
    m->rhs[r] = remainder_of(m, system->matrix, m->unknown[r], rhs[m->unknown[r]], y);
  }
  sct_status status = sct_solver_solve(m->solver, m->rhs, false, m->x, err);
  for (int64_t r = 0; status == SCT_OK && r < m->rows; r++) y[m->unknown[r]] = m->x[r];
  return status;
}

/* With C the covered rows and E the others, M = [I 0; A_CE A_CC]: y_C = A_CC^-T rhs_C,
 * y_E = rhs_E - A_CE^T y_C. */
sct_status sct_march_matrix_solve_transposed(sct_march_matrix *m, const sct_system *system,
                                             const double *rhs, double *y, sct_error *err) {
  const sct_csr *a = system->matrix;
  if (m->rows == system->unknowns && m->rows > 0) {
    return sct_solver_solve(m->solver, rhs, true, y, err);
  }
  memcpy(y, rhs, (size_t)system->unknowns * sizeof *y);
  if (m->rows == 0) return SCT_OK;
  for (int64_t r = 0; r < m->rows; r++) m->rhs[r] = rhs[m->unknown[r]];
  sct_status status = sct_solver_solve(m->solver, m->rhs, true, m->x, err);
  if (status != SCT_OK) return status;
  for (int64_t r = 0; r < m->rows; r++) {
    const int32_t i = m->unknown[r];
    y[i] = m->x[r];
    for (int64_t k = a->start[i]; k < a->start[i + 1]; k++) {
      if (m->row_of[a->column[k]] < 0) y[a->column[k]] -= a->value[k] * m->x[r];
    }
  }
  return SCT_OK;
}

const sct_solve_report *sct_march_matrix_report(const sct_march_matrix *m) {
  return m->solver == NULL ? NULL : sct_solver_report(m->solver);
}

int64_t sct_march_matrix_factorisations(const sct_march_matrix *m) {
  return m->factorisations;
}
