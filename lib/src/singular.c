/* singular.c - why a system may be singular: unknowns that nothing holds.
 *
 * A row whose entries (matrix and coupling) sum to zero annihilates constants. A set of such rows
 * that refers to no Dirichlet point and to no row outside the set has the constant as a null
 * vector. So a row is held if it does not sum to zero, refers to a Dirichlet point, or refers to a
 * row that is held; what remains is the cause. A row without any entry, or without one in the
 * matrix, is more obvious and told first.
 */
#include <float.h>
#include <inttypes.h>
#include <math.h>

#include "alloc.h"
#include "scatter/assemble.h"

/* Row sums below this part of the row's size are rounding. */
static const double ROUNDING = 1e-12;

static bool holds_itself(const sct_system *system, int64_t row) {
  const sct_csr *a = system->matrix;
  double sum = 0, size = 0;
  if (system->coupling->start[row + 1] > system->coupling->start[row]) return true;
  for (int64_t e = a->start[row]; e < a->start[row + 1]; e++) {
    sum += a->value[e];
    size += fabs(a->value[e]);
  }
  return fabs(sum) > ROUNDING * size;
}

/* users: for each column the rows that refer to it. */
static sct_status transpose_pattern(const sct_csr *a, int64_t **start, int32_t **users,
                                    sct_error *err) {
  sct_status status = sct_alloc_zero(start, a->columns + 2, sizeof **start, err);
  if (status == SCT_OK) status = sct_alloc(users, sct_csr_entries(a), sizeof **users, err);
  if (status != SCT_OK) return status;
  int64_t *at = *start + 1; /* one ahead, so that filling moves each start into its place */
  for (int64_t e = 0; e < sct_csr_entries(a); e++) at[a->column[e] + 1]++;
  for (int64_t c = 0; c < a->columns; c++) at[c + 1] += at[c];
  for (int64_t row = 0; row < a->rows; row++) {
    for (int64_t e = a->start[row]; e < a->start[row + 1]; e++) {
      (*users)[at[a->column[e]]++] = (int32_t)row;
    }
  }
  return SCT_OK;
}

/* Marks every row from which a row in queue[0 .. end-1] can be reached; returns the new end. */
static int64_t spread(const int64_t *start, const int32_t *users, uint8_t *mark, int32_t *queue,
                      int64_t end) {
  for (int64_t next = 0; next < end; next++) {
    for (int64_t e = start[queue[next]]; e < start[queue[next] + 1]; e++) {
      const int32_t row = users[e];
      if (mark[row]) continue;
      mark[row] = 1;
      queue[end++] = row;
    }
  }
  return end;
}

static void describe(const sct_system *system, const uint8_t *held, int64_t loose, sct_error *err) {
  sct_error cause = {.code = SCT_OK};
  if (loose == system->unknowns) {
    sct_fail(
        &cause, SCT_E_SINGULAR, -1,
        "no point has a Dirichlet or Robin condition or a reaction: the solution is determined "
        "up to a constant only; give the value of at least one point");
  } else {
    sct_fail(&cause, SCT_E_SINGULAR, -1,
             "%" PRId64
             " points hang on no Dirichlet or Robin condition and on no reaction (an "
             "isolated group of points?): the solution there is determined up to a constant only",
             loose);
  }
  for (int64_t row = 0; loose < system->unknowns && row < system->unknowns; row++) {
    if (!held[row]) sct_error_add_point(&cause, system->point_of[row]);
  }
  if (err != NULL) *err = cause;
}

static bool is_blank(const sct_csr *a, int64_t row) {
  for (int64_t e = a->start[row]; e < a->start[row + 1]; e++) {
    if (!(fabs(a->value[e]) < DBL_MIN)) return false;
  }
  return true;
}

/* Are there points whose equation has no unknown in it, and (`is_coupled`) a Dirichlet value or
 * (else) nothing at all? */
static bool find_blank(const sct_system *system, bool is_coupled, sct_error *err) {
  sct_error cause = {.code = SCT_OK};
  for (int64_t row = 0; row < system->unknowns; row++) {
    if (!is_blank(system->matrix, row)) continue;
    if (is_blank(system->coupling, row) == is_coupled) continue;
    if (cause.count == 0) {
      sct_fail(&cause, SCT_E_SINGULAR, system->point_of[row],
               is_coupled
                   ? "has an equation without an unknown: the weights of its neighbours "
                     "cancel (a central gradient without diffusivity?)"
                   : "has no equation: diffusivity, velocity and reaction are all zero there");
    } else {
      sct_error_add_point(&cause, system->point_of[row]);
    }
  }
  if (cause.count > 0 && err != NULL) *err = cause;
  return cause.count > 0;
}

bool sct_system_explain(const sct_system *system, sct_error *err) {
  if (find_blank(system, false, err) || find_blank(system, true, err)) return true;
  const int64_t m = system->unknowns;
  int64_t *start = NULL, end = 0;
  int32_t *users = NULL, *queue = NULL;
  uint8_t *held = NULL;
  bool found = false;
  sct_status status = transpose_pattern(system->matrix, &start, &users, NULL);
  if (status == SCT_OK) status = sct_alloc(&queue, m, sizeof *queue, NULL);
  if (status == SCT_OK) status = sct_alloc_zero(&held, m, sizeof *held, NULL);
  if (status != SCT_OK) goto done; /* no memory to look: no cause found */
  for (int64_t row = 0; row < m; row++) {
    if (!holds_itself(system, row)) continue;
    held[row] = 1;
    queue[end++] = (int32_t)row;
  }
  end = spread(start, users, held, queue, end);
  found = end < m;
  if (found) describe(system, held, m - end, err);
done:
  sct_release(&start);
  sct_release(&users);
  sct_release(&queue);
  sct_release(&held);
  return found;
}
