/* limited.h - convection that is bounded and of second order: slope-limited edges.
 *
 * With the balanced weights k_ij = u_i . g_ij (sum_j k_ij = 0; stencil.h, upwind `limited`)
 *   (u . grad phi)_i = sum_j 2 k_ij (phi_ij - phi_i),                                        (1)
 * phi_ij the value half-way to j, reconstructed from its upwind side with D = phi_j - phi_i:
 *   k_ij > 0: phi_i + l(2 G_i . r_j - D, D) / 2      k_ij < 0: phi_j - l(2 G_j . r_j - D, D) / 2
 *   l(a, b) = a b (a + b) / (a^2 + b^2) where a b > 0, else 0       (van Albada et al. 1982) (2)
 * G is the gradient of ips for mps and ps, else the scheme's own (lsmps: of second degree), and
 * that of the edges on points with a condition. In the first case the first argument of l is cut
 * off at
 *   -2 max_j D <= a <= -2 min_j D                                                            (3)
 * the last D running over all neighbours of i, and a pair weight a_ij < 0 of a diffusion or of a
 * normal derivative acts on D cut off in the same way.
 *
 * The system of such a stencil holds the first-order part as a matrix A,
 *   A phi: sum_j (a_ij + 2 max(0, -k_ij)) (phi_i - phi_j) + k_i phi_i,
 * and what is left is the correction q(phi),
 *   q_i = -sum_j |k_ij| l_ij + sum_(a_ij < 0) |a_ij| (D - cut off D),      A phi = b + q(phi) (4)
 *
 * Bounded: by (2) and (3) every row of (4) is sum_j c_ij (phi_i - phi_j) + k_i phi_i = b_i with
 * c_ij(phi) >= 0, whatever the cloud, the scheme and the Peclet number: a steady solution without
 * source, reaction and flux lies between the least and the largest Dirichlet value, backward Euler
 * between these and the initial ones. Crank-Nicolson and forward Euler do so up to
 * sct_march_stable_step (twice that for Crank-Nicolson); BDF2 does not, but for small overshoots.
 * Second order on any cloud with lsmps: (1) to (3) are exact for linear functions, the gradients
 * too, and G of second degree leaves (1) an error of h^2; at extrema l drops to zero (first order
 * on a part h of the domain). Cutting off costs accuracy where weights are negative and phi has an
 * extremum only.
 */
#ifndef SCATTER_LIMITED_H
#define SCATTER_LIMITED_H

#include "scatter/assemble.h"
#include "scatter/solve.h"

#ifdef __cplusplus
extern "C" {
#endif

/* q(phi) of (4). phi [n], all points; gradient [n][dim] is overwritten with G; q [unknowns] out.
 * The system must hold a `limited`. Threads of `work` share the points. Cost O(entries).
 * Proof: unit.limited (against (1) to (4) by hand), verify.limited */
void sct_limited_correction(const sct_system *system, const double *phi, const sct_work *work,
                            double *gradient, double *q);

/* What row `row` of (4) adds to its Gershgorin disc (1 / time), so that 2 / (disc) is a step in
 * which forward Euler keeps to the bounds: 2 sum_j (2.42 max(0, k_ij) + 2 max(0, -a_ij)); 0 for a
 * system without `limited`. */
double sct_limited_reach(const sct_system *system, int64_t row);

enum { SCT_LIMITED_HISTORY = 512, SCT_LIMITED_ITERATIONS = 200 };
#define SCT_LIMITED_TOLERANCE 1e-8

/* Sets what is asked of one back-substitution: a backward error of 1e-8 of a direct solver, a
 * relative residual of 1e-4 of an iterative one, for the iteration refines by itself; and, where
 * the method is left to choose, a direct one in one and two dimensions, whose factors serve it some
 * 30 times. */
void sct_limited_relax(sct_solve_options *solve);

typedef struct {
  double tolerance; /* of max |change| / max |phi|; 0: SCT_LIMITED_TOLERANCE; at least 1e-13 */
  int64_t max_iterations; /* back-substitutions; 0: SCT_LIMITED_ITERATIONS */
} sct_limited_options;

typedef struct {
  int64_t iterations;                  /* back-substitutions of the last solve */
  int64_t total, most;                 /* over all solves of a march; in one of them */
  double residual;                     /* max |change| / max |phi| of the last one */
  double history[SCT_LIMITED_HISTORY]; /* of every one of the last solve, the first 512 */
} sct_limited_report;

/* Solves (4) by defect correction, phi <- phi + A^-1 (b + q(phi) - A phi), with Anderson
 * acceleration over 8 steps (Anderson 1965; Walker and Ni 2011); the first step ends at the
 * first-order solution. `solver` holds the factors of system->matrix. phi [n]: Dirichlet values
 * given, solution out; `report` and `work` may be NULL; progress is phase "solve".
 * SCT_E_CONVERGENCE if the change is still above the tolerance after max_iterations: phi is then
 * the last iterate and no solution. SCT_E_MEMORY, SCT_E_CANCELLED, statuses of sct_solver_solve.
 * Cost: one back-substitution and one correction per iteration; 5 to 51 of them, more, or no end,
 * on closed streamlines with next to no diffusion and on points strewn at random (lib/README.md).
 * Proof: verify.limited (bounds, order, iterations, Smith-Hutton), unit.limited (failures) */
SCT_NODISCARD sct_status sct_limited_solve(const sct_system *system, sct_solver *solver,
                                           const sct_limited_options *options, const sct_work *work,
                                           double *phi, sct_limited_report *report, sct_error *err);

#ifdef __cplusplus
}
#endif
#endif
