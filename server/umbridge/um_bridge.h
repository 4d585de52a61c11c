/* um_bridge.h - UM-Bridge 1.0 (https://um-bridge-benchmarks.readthedocs.io): evaluations and
 * derivatives of a model, for uncertainty quantification. The worker's side: one request, from its
 * bytes to its reply.
 *
 * A failure is {"error": {"type", "message"}}; what is looked at, in this order:
 *   ModelNotFound 400       there is no model of that name
 *   UnsupportedFeature 400  it cannot do this
 *   InvalidInput 400        body, config, input, indices, directions
 *   InvalidOutput 500       the solve failed
 * What keeps a request from its model is told by the front, in the same form (model_error.h).
 * Test: http.um_bridge.
 */
#ifndef SCATTERD_UM_BRIDGE_H
#define SCATTERD_UM_BRIDGE_H

#include "answer.h"

/* Is this "process" of an ask one of UM-Bridge: "um-bridge/Evaluate"? */
bool um_bridge_is(const char *id);

void um_bridge_answer(const ask *ask, reply *reply);

#endif
