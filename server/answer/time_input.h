/* time_input.h - the inputs `time` and `solver`: how to march, how to solve. Proof: unit.answer */
#ifndef SCATTERD_TIME_INPUT_H
#define SCATTERD_TIME_INPUT_H

#include "read.h"
#include "scatter/march.h"

/* Reads `time`: method (crank-nicolson), start (0), end, save, and step or else diffusion_number
 * (1). *march is zeroed where the input is absent. False with complaints. */
bool time_input_read(task *t, const item *it, sct_march_options *march);

/* Reads `solver` into march->solve and march->limited, which of both will use what: the method, its
 * tolerance, max_iterations and preconditioner. What is left out stays 0, the library's default.
 * False with complaints. */
bool solver_input_read(task *t, const item *it, sct_march_options *march);

#endif
