/* estimate.h - the memory a run needs at its peak, told before it runs, so that it can be admitted
 * or refused.
 *
 * Fits to measured peaks, meant to lie a little above them: 0 to 50 % (tests/bench/bench_memory.py
 * measures; the table is in server/README.md). n points in d dimensions, m neighbours each:
 *   stencils       n (a + b m)
 *   iteration      n (c + d m)
 *   factorisation  c_1 n in 1-D, c_2 n log2 n in 2-D, c_3 n^(4/3) in 3-D, by m: nested dissection's
 *                  growth [George 1973], which AMD and METIS keep to at these sizes
 * Proof: unit.estimate (order, monotony), tests/bench/bench_memory.py (size)
 */
#ifndef SCATTERD_ESTIMATE_H
#define SCATTERD_ESTIMATE_H

#include "perform.h"
#include "scatter/stencil.h"

/* The whole process that runs the request (bytes). */
int64_t estimate_run(const task *t, const performance *f);

/* Parts, for the `memory` of a process (bytes): what every point costs (cloud, search, stencils,
 * fields, the result as text), what a factored system costs beyond it, and one iterated with. */
int64_t estimate_points(int dim, int64_t n, const sct_operator *op);
int64_t estimate_system(int dim, int64_t n, const sct_operator *op);
int64_t estimate_iteration(int dim, int64_t n, const sct_operator *op);

/* Neighbours of a point of a lattice within the radius of the operator. */
double estimate_neighbours(int dim, double radius);

#endif
