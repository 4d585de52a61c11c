/* time_input.h - the inputs `time` and `solver`: how to march, how to solve. Proof: unit.answer */
#ifndef SCATTERD_TIME_INPUT_H
#define SCATTERD_TIME_INPUT_H

#include "read.h"
#include "scatter/march.h"

/* Reads `time`: method (crank-nicolson), start (0), end, save, and step or else diffusion_number
 * (1). *march is zeroed where the input is absent. False with complaints. */
bool time_input_read(task *t, const item *it, sct_march_options *march);

/* Reads `solver`: the method, and for iterative ones tolerance, max_iterations and preconditioner. */
bool solver_input_read(task *t, const item *it, sct_solve_options *solve);

#endif
