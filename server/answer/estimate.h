/* estimate.h - the memory a run needs at its peak, told before it runs, so that it can be admitted
 * or refused.
 *
 * Fits to measured peaks, a little above them (tests/bench/memory.md has the table,
 * tests/bench/bench_memory.py measures). n points in d dimensions, m neighbours each, bytes:
 *   points   n (250 + 14 m)         cloud, search, stencils, fields, the result as text
 *   matrix   n (40 + 22 m)          the assembled system
 *   factors  200 n                          in 1-D
 *            n m^0.8 (44 log2 n - 300)      in 2-D
 *            n m^0.57 (720 + 1.12 n^(2/3))  in 3-D
 *   limited  n (264 + 16 d + m (42 + 12 d))  upwind `limited`: acceleration, gradients, edges
 *   iterative solver  3e7 + n (420 + 8 m)
 *   N ranks, each   6e7 + 160 n + 5/4 of the above / N
 * A run that falls back from it on factors may need more than was told. The growth of the factors
 * is that of nested dissection on planar and spatial graphs (n log n and n^(4/3) [George 1973]) as
 * far as n = 5e5 in 2-D; in 3-D, up to n = 1e5, measured as n^(5/3). Proof: unit.estimate,
 * tests/bench/bench_memory.py
 */
#ifndef SCATTERD_ESTIMATE_H
#define SCATTERD_ESTIMATE_H

#include "perform.h"
#include "scatter/solve.h"
#include "scatter/stencil.h"

/* The whole process that runs the request (bytes). */
int64_t estimate_run(const task *t, const performance *f);

/* All processes that share a run: each has its share of it, and all of the fields (bytes). */
int64_t estimate_shared(const task *t, int64_t run, int64_t processes);

/* Parts, for the `memory` of a process (bytes), as above. */
int64_t estimate_points(int dim, int64_t n, const sct_operator *op);
int64_t estimate_matrix(int dim, int64_t n, const sct_operator *op);
int64_t estimate_factors(int dim, int64_t count, const sct_operator *op);
int64_t estimate_limited(int dim, int64_t n, const sct_operator *op); /* 0 with another upwind */

/* What solves the system: factors, or the iterative solver where these options mean it. */
int64_t estimate_solver(int dim, int64_t n, const sct_operator *op,
                        const sct_solve_options *options);

int64_t estimate_iteration(int dim, int64_t n, const sct_operator *op); /* iterative, always */

/* Neighbours of a point of a lattice within the radius of the operator. */
double estimate_neighbours(int dim, double radius);

#endif
