/* limited_iterate.h - defect correction with Anderson acceleration, for a steady system and for one
 * step of a march alike. */
#ifndef SCATTER_LIMITED_ITERATE_H
#define SCATTER_LIMITED_ITERATE_H

#include "scatter/limited.h"

/* What is to be solved for y [unknowns], in the terms of scatter/limited.h, (4):
 *   equation rows    own y + shift (A y - q(y)) = rhs
 *   condition rows   A y - q(y) = rhs                                                         (5)
 * steady: own 0, shift 1; a step: own 1, shift the time step times the weight of the new time. */
typedef struct {
  const sct_system *system;
  double own, shift;
  const double *rhs;  /* [unknowns] */
  bool starts_linear; /* the first iteration leaves q out: it ends at the first-order solution */
  /* x [unknowns] from r: (5) without q, in factors */
  sct_status (*solve)(void *context, const double *r, double *x, sct_error *err);
  void *context;
} sct_limited_equation;

typedef struct sct_limited_iteration sct_limited_iteration; /* memory to iterate in */

/* *iteration is NULL on failure. SCT_E_MEMORY. */
SCT_NODISCARD sct_status sct_limited_iteration_new(const sct_system *system,
                                                   sct_limited_iteration **iteration,
                                                   sct_error *err);
void sct_limited_iteration_free(sct_limited_iteration **iteration);

/* q [unknowns] of Dirichlet values phi [n] (the others are not read) and unknowns y; the memory is
 * the iteration's, until its next call. */
const double *sct_limited_iteration_correction(sct_limited_iteration *iteration,
                                               const sct_system *system, const double *phi,
                                               const double *y, const sct_work *work);

/* Solves; y is the start and the solution, phi as above. Counts into *report. Progress is told to
 * `work` as phase `phase`, if that is not NULL. Statuses of sct_limited_solve. */
SCT_NODISCARD sct_status sct_limited_iterate(sct_limited_iteration *iteration,
                                             const sct_limited_equation *equation,
                                             const sct_limited_options *options,
                                             const sct_work *work, const char *phase,
                                             const double *phi, double *y,
                                             sct_limited_report *report, sct_error *err);

#endif
