/* derivative.h - how an output vector of a model changes with an input vector, by one solve more:
 * the adjoint one for the gradient, the tangent one for the action of the Jacobian, with the
 * factors of a steady solve still at hand, over the recorded steps of one in time (adjoint.h).
 * Test: http.um_bridge.
 */
#ifndef SCATTERD_DERIVATIVE_H
#define SCATTERD_DERIVATIVE_H

#include "model.h"

/* Can the model be differentiated? Not with an upwinding that is not linear in phi. */
bool derivative_is_possible(const model *m);

/* gradient [inputs of vector `in`] = J^T sens, sens [size of output `out`]; computes the solve.
 * False with t->error or complaints. */
bool derivative_gradient(task *t, model *m, int64_t out, int64_t in, const double *sens,
                         double *gradient);

/* change [size of output `out`] = J vec, vec [inputs of vector `in`]. Likewise. */
bool derivative_apply(task *t, model *m, int64_t out, int64_t in, const double *vec,
                      double *change);

#endif
