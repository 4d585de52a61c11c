/* operator_input.h - the input `operator`: scheme, kernel and support. Proof: unit.answer */
#ifndef SCATTERD_OPERATOR_INPUT_H
#define SCATTERD_OPERATOR_INPUT_H

#include "read.h"
#include "scatter/stencil.h"

/* Reads the input; what is left out has the default of its scheme (sct_operator_default), the
 * scheme itself lsmps of degree 2. False with complaints. */
bool operator_input_read(task *t, const item *it, sct_operator *op);

/* The same where another scheme is the one that is left out. */
bool operator_input_read_else(task *t, const item *it, sct_scheme otherwise, sct_operator *op);

#endif
