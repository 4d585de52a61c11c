/* march_scheme.h - the table of time schemes: what is weighed in one step. */
#ifndef SCATTER_MARCH_SCHEME_H
#define SCATTER_MARCH_SCHEME_H

#include "scatter/march.h"

/* Equation rows of one step of length dt, y'' being the values one step before y, f = b - A y:
 *   (I + implicit dt A') y' = now y + before y'' + explicit dt f + implicit dt b'           (1) */
typedef struct {
  double implicit, explicit, now, before;
} sct_march_weights;

/* Largest ratio of a step to the one before over which BDF2 goes on; beyond, it starts anew with
 * backward Euler. Zero-stable up to 1 + sqrt 2 (Grigorieff 1983). */
#define SCT_BDF2_RATIO 2.0

/* Weights of a step `ratio` times as long as the one before; ratio 0: there is none before. */
sct_march_weights sct_march_weigh(sct_march_method method, double ratio);

/* Does a step use the rate at its old level? */
bool sct_march_uses_old_rate(sct_march_method method);

#endif
