/* adjoint.h - derivatives of a march with respect to its data, forward (tangent) and backward
 * (adjoint), of the very steps that were taken.
 *
 * Level k of a march is its state after step k, level 0 the start. With the weights of a scheme
 * (theta implicit, e explicit, and those of the levels before) step k of length dt solves
 *   equation   y_k + theta dt (A_k y_k - b_k) = now y_k-1 + before y_k-2 - e dt (A y - b)_k-1
 *   condition  A_k y_k - b_k = 0                                                               (1)
 * Differentiated, with R'_k of slope.h at level k, M_k the matrix on the left of (1):
 *   M_k y'_k = [now y'_k-1 + before y'_k-2 - e dt (A y' + R')_k-1 - theta dt R'_k;  -R'_k]      (2)
 * and transposed, from the last level down, lambda_k = M_k^-T (what later levels hand to y_k):
 *   dq = - sum_k kappa_k . R'_k + lambda_0 . y'_0,
 *   kappa_k = [theta dt lambda_k + (e dt lambda)_k+1;  lambda_k]                               (3)
 * so (2) and (3) give the same number to rounding. The start is level 0 of both: schemes that use
 * the rate there impose the conditions on it first (march.h), by a "step" of theta = 0.
 */
#ifndef SCATTER_ADJOINT_H
#define SCATTER_ADJOINT_H

#include "scatter/march.h"

#ifdef __cplusplus
extern "C" {
#endif

/* R' of level k into r [unknowns], for the change asked about; phi [n] as recorded (NULL without
 * values). Called for k = 0 .. N in order, the system being at time t. */
typedef sct_status sct_tangent_slope(void *context, double t, const double *phi, double *r,
                                     sct_error *err);

/* Takes kappa_k [unknowns] of (3) in; called for k = N .. 0. */
typedef sct_status sct_adjoint_absorb(void *context, double t, const double *phi,
                                      const double *kappa, sct_error *err);

/* A march as recorded, and the problem it was the march of: `system` is brought to other times by
 * problem->advance, if the problem varies. `options` are those of the march. */
typedef struct {
  const sct_tape *tape;
  const sct_march_options *options;
  sct_system **system;
  const sct_march_problem *problem; /* may be NULL */
  const sct_work *work;             /* may be NULL */
} sct_replay;

/* phi [n]: the change of the initial values in, that of the last level out, at unknowns; Dirichlet
 * points are left as they are. Statuses of sct_march and of what it calls back. Progress is phase
 * "tangent". Cost of a march whose factors are found again. Proof: verify.adjoint (central
 * differences of the march, every scheme) */
SCT_NODISCARD sct_status sct_march_tangent(const sct_replay *replay, sct_tangent_slope *slope,
                                           void *context, double *phi, sct_error *err);

/* phi [n]: dq/dphi at the last level in (read at unknowns), dq/d(initial value) out, 0 at Dirichlet
 * points. Progress is phase "adjoint". Otherwise as above. Proof: verify.adjoint (differences, and
 * the identity with the tangent to rounding) */
SCT_NODISCARD sct_status sct_march_adjoint(const sct_replay *replay, sct_adjoint_absorb *absorb,
                                           void *context, double *phi, sct_error *err);

#ifdef __cplusplus
}
#endif
#endif
