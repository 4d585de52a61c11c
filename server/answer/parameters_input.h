/* parameters_input.h - the input `parameters`: numbers with names, for expressions.
 * Proof: unit.answer
 */
#ifndef SCATTERD_PARAMETERS_INPUT_H
#define SCATTERD_PARAMETERS_INPUT_H

#include "read.h"

/* Reads the input into t->parameters, before any expression is. False with complaints. */
bool parameters_input_read(task *t, const item *it);

#endif
