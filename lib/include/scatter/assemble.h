/* assemble.h - from an equation on a cloud to a sparse system.
 *
 *   d phi / dt + u . grad phi = div(mu grad phi) + s - k phi                            (1)
 * on interior points, with on the others
 *   dirichlet  phi = value
 *   neumann    n . grad phi = value
 *   robin      coefficient phi + n . grad phi = value
 */
#ifndef SCATTER_ASSEMBLE_H
#define SCATTER_ASSEMBLE_H

#include "scatter/csr.h"
#include "scatter/stencil.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum { SCT_INTERIOR, SCT_DIRICHLET, SCT_NEUMANN, SCT_ROBIN } sct_condition;

/* Fields of (1), point by point; NULL is zero (diffusivity: must be given). All are borrowed. */
typedef struct {
  const double *velocity;    /* [n][dim] (length / time) */
  const double *diffusivity; /* [n] >= 0 (length^2 / time) */
  const double *source;      /* [n] (phi / time) */
  const double *reaction;    /* [n] (1 / time) */
} sct_fields;

typedef struct {
  const uint8_t *condition;  /* [n] sct_condition */
  const double *value;       /* [n], read where condition is not interior; NULL: 0 */
  const double *coefficient; /* [n], read at robin points; NULL only without any */
  const double *normal;      /* [n][dim], read at neumann and robin points; NULL only without any;
                                normalised here, must not be zero */
} sct_boundary;

/* The system A phi = b of the points that are not Dirichlet (unknowns):
 *   equation rows    sum_j a_ij (phi_i - phi_j) + k_i phi_i = s_i with
 *                    a_ij = (mu_i + mu_j)/2 l_ij - u_i . g_ij                           (2)
 *   condition rows   c phi_i + sum_j n . g_ij (phi_j - phi_i) = value
 * (2) is the pair form of div(mu grad phi): for any row that is exact for quadratics it equals
 * mu lap phi + grad mu . grad phi, and it keeps the sign of l_ij.
 * With upwind `limited`, a_ij = (mu_i + mu_j)/2 l_ij + 2 max(0, -u_i . g_ij): the first-order part.
 * Dirichlet points are eliminated: matrix holds the columns of unknowns, coupling those of
 * Dirichlet points, so that b = load - coupling phi. */
typedef struct {
  int64_t n, unknowns;
  int32_t *row_of;      /* [n] row of a point, -1 for Dirichlet points */
  int32_t *point_of;    /* [unknowns] */
  uint8_t *is_equation; /* [unknowns] 1: equation row, 0: condition row */
  sct_csr *matrix;      /* unknowns x unknowns */
  sct_csr *coupling;    /* unknowns x n */
  double *load;         /* [unknowns] s_i, or the condition's value */
  /* upwind `limited`: what is to be added to the matrix (limited.h), else NULL */
  struct sct_limited *limited;
  int64_t widened;  /* points whose support was widened */
  int64_t fallback; /* points whose row is of another scheme or degree */
  int64_t loose;    /* points whose row is far from that of an M-matrix */
} sct_system;

/* Assembles. SCT_E_ARGUMENT (negative diffusivity, zero normal, no unknown: err->point),
 * SCT_E_NOT_FINITE, SCT_E_DEFICIENT with all points concerned, SCT_E_MEMORY. *system is NULL on
 * failure. Cost O(entries). Proof: verify.assemble, verify.order, verify.monotone */
SCT_NODISCARD sct_status sct_system_build(const sct_stencil *stencil, const sct_fields *fields,
                                          const sct_boundary *boundary, const sct_work *work,
                                          sct_system **system, sct_error *err);
void sct_system_free(sct_system **system);

/* Sets load anew from the fields' source and the boundary's values (of another time, say); the
 * conditions themselves must be those of the build. */
void sct_system_load(sct_system *system, const double *source, const double *value);

/* b = load - coupling phi, phi [n] read at Dirichlet points only; b [unknowns] out. */
void sct_system_rhs(const sct_system *system, const double *phi, double *b);

/* Why a system may be singular: unknowns whose rows are empty; if there are none, those that refer
 * to no Dirichlet point, Robin row or reaction, even by way of others, which are determined up to a
 * constant only. Writes that into `err` as SCT_E_SINGULAR (their points in err->points, unless it
 * is all of them) and returns true; false if there are none, or no memory to look. Cost O(entries).
 * Proof: unit.assemble */
bool sct_system_explain(const sct_system *system, sct_error *err);

#ifdef __cplusplus
}
#endif
#endif
