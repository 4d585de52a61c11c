/* solve_policy.h - which solver and which preconditioner suit a matrix; every number here was
 * measured on matrices of this library (tests/bench/bench_solve.md, "Iterative solves").
 *
 * A matrix says by some of its rows what it comes from:
 *   dominance  share of rows with sum_(j != i) |a_ij| <= 0.98 |a_ii|: near 1 for the matrix of a
 *              short time step (up to some 15 times the stable explicit one), near 0 else
 *   skewness   sum |a_ij - a_ji| / sum (|a_ij| + |a_ji|) with a unit diagonal: with upwinding
 *              about Pe / (2 + Pe) for a cell Peclet number Pe, below 0.1 for diffusion
 */
#ifndef SCATTER_SOLVE_POLICY_H
#define SCATTER_SOLVE_POLICY_H

#include "scatter/solve.h"

typedef struct {
  int dim;
  int64_t rows;
  double dominance, skewness; /* in [0, 1] */
} sct_solve_traits;

/* Looks at a thousand rows of a square matrix with sorted rows. */
sct_solve_traits sct_solve_traits_of(const sct_csr *a, int dim);

/* Where KLU and UMFPACK cross over. */
bool sct_solve_suits_klu(int64_t rows, int dim);

/* Where `auto` iterates. */
bool sct_solve_suits_iteration(const sct_solve_traits *traits);

/* May a direct solver take over from an iterative one? Above, it would need hours, and all there is
 * of memory. */
bool sct_solve_suits_fallback(int64_t rows, int dim);

/* Preconditioners: incomplete factors; multigrid whose first level is coarsened carefully (fewest
 * iterations), or aggressively (least work to set up, half the memory, unimpressed by convection)
 */
typedef enum { SCT_ILU, SCT_AMG, SCT_AMG_AGGRESSIVE } sct_preconditioner;
sct_preconditioner sct_solve_preconditioner(const sct_solve_traits *traits);
sct_preconditioner sct_solve_multigrid(const sct_solve_traits *traits);

#endif
