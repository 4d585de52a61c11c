/* slope.h - how a system changes with the data of its equation: the first derivatives of its rows.
 *
 * A system (assemble.h) is the equation R(phi; data) = 0 of its unknowns, row by row
 *   equation   R_i = sum_j a_ij (phi_i - phi_j) + k_i phi_i - s_i,
 *              a_ij = (mu_i + mu_j)/2 l_ij - u_i . g_ij(u_i, mu_i)
 *   condition  R_i = c_i phi_i + sum_j n . g_ij (phi_j - phi_i) - value_i
 * and phi_j = value_j at Dirichlet points. Where the data change by a dot each, phi of the
 * unknowns held, R changes by
 *   equation   R'_i = sum_j a'_ij (phi_i - phi_j) + k'_i phi_i - s'_i + D_i
 *   condition  R'_i = c'_i phi_i - value'_i + D_i,  D_i = sum_(j Dirichlet) A_ij value'_j      (1)
 * with, g_ij depending on u_i and mu_i where it is upwinded,
 *   a'_ij = (mu'_i + mu'_j)/2 l_ij - u'_i . g_ij - u_i . g'_ij                                 (2)
 * The solution of A phi = b then changes by A phi' = -R' (tangent), and a number q(phi) by
 * -lambda . R' with A^T lambda = dq/dphi (adjoint): R' is linear in the change of the data, so its
 * transpose turns lambda into the gradient of q with respect to all data at once.
 * Points keep their places: geometry has no slope.
 */
#ifndef SCATTER_SLOPE_H
#define SCATTER_SLOPE_H

#include "scatter/assemble.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A change of the data of a system, or a gradient with respect to them, by point; NULL: this one
 * does not change, is not asked for. */
typedef struct {
  double *velocity;    /* [n][dim] */
  double *diffusivity; /* [n] */
  double *source;      /* [n] read at equation rows */
  double *reaction;    /* [n] */
  double *value;       /* [n] read where a condition is */
  double *coefficient; /* [n] read at condition rows; to be zero where the condition is not robin */
} sct_data;

typedef struct sct_slope sct_slope; /* opaque: (2) entry by entry, nothing borrowed */

/* Takes the slopes of a system's entries at the data it was built from; `moving`: velocity or
 * diffusivity may change (else the rows are constant and this costs nothing). l_ij and, without
 * upwinding, g_ij make (2) exact; an upwinded g_ij(u, mu), which is smooth but where u = 0 (there
 * it is central), is differenced numerically with error of the order h^4 and a step of a thousandth
 * of |u| and mu, 1e-11 of the entries as measured. SCT_E_ARGUMENT (a row whose support changes with
 * the velocity: with the point; upwind `limited`, which has kinks), SCT_E_DEFICIENT, SCT_E_MEMORY,
 * SCT_E_CANCELLED; *slope is NULL on failure. Cost: two rows per point, 4 (dim + 1) more where it
 * is upwinded; (dim + 2) numbers per entry. Proof: verify.slope (central differences of the
 * assembled residual) */
SCT_NODISCARD sct_status sct_slope_build(const sct_stencil *stencil, const sct_fields *fields,
                                         const sct_system *system, bool moving,
                                         const sct_work *work, sct_slope **slope, sct_error *err);
void sct_slope_free(sct_slope **slope);

/* r [unknowns] = R' of (1) for a change of the data, at phi [n]; phi may be NULL where velocity,
 * diffusivity, reaction and coefficient do not change. Cost O(entries). Proof: verify.slope */
void sct_slope_apply(const sct_slope *slope, const sct_system *system, const sct_data *change,
                     const double *phi, double *r);

/* Its transpose: gradient += factor dR'/d(change)^T weight for those members that are not NULL, so
 * that weight . R'(change) = gradient . change. weight [unknowns]. Proof: verify.slope (the
 * identity, to rounding) */
void sct_slope_apply_transposed(const sct_slope *slope, const sct_system *system, double factor,
                                const double *weight, const double *phi, sct_data *gradient);

#ifdef __cplusplus
}
#endif
#endif
