/* march_plan.h - the times of a march: stops (save times and the end), and steps between them. */
#ifndef SCATTER_MARCH_PLAN_H
#define SCATTER_MARCH_PLAN_H

#include "scatter/march.h"

/* SCT_E_ARGUMENT for a scheme, time or step that is none. */
SCT_NODISCARD sct_status sct_march_plan_check(const sct_march_options *options, sct_error *err);

/* Number of stops; stop k, where -1 is the start. */
int64_t sct_march_stops(const sct_march_options *options);
double sct_march_stop(const sct_march_options *options, int64_t k);

/* Number of steps of at most dt over a length, a whole one in a double: it may be huge. */
double sct_march_steps_over(double length, double dt);

/* *steps = those of the whole march with steps of at most dt. SCT_E_LIMIT. */
SCT_NODISCARD sct_status sct_march_plan_count(const sct_march_options *options, double dt,
                                              double *steps, sct_error *err);

#endif
