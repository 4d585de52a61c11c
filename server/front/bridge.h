/* bridge.h - UM-Bridge 1.0 at the root: hands the body of POST /Evaluate and its like to a worker,
 * as process um-bridge/Evaluate (umbridge/um_bridge.h), whatever its Content-Type; what becomes of
 * it otherwise, and every refusal before, is told as an error of UM-Bridge (model_error.h), no
 * problem document. Test: http.um_bridge.
 */
#ifndef SCATTERD_BRIDGE_H
#define SCATTERD_BRIDGE_H

#include "exchange.h"
#include "service.h"

/* GET /Info: the models. */
void bridge_info(const service *s, exchange *x);

/* As those of execute.h. */
void bridge_begin(const service *s, exchange *x);
void bridge_serve(const service *s, exchange *x);
void bridge_end(const service *s, exchange *x);

#endif
