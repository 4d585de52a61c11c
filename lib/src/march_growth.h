/* march_growth.h - how large can phi have become? A bound from the data; beyond it the march is
 * unstable, whatever the scheme.
 *
 * Continuous problems obey a maximum principle: |phi| <= B with
 *   B(0) = max |phi|,   dB/dt = growth B + source                                            (1)
 * and B never below the Dirichlet values. Here
 *   growth  max over equation rows of -k_i (reaction that feeds), k_i the sum of the row, plus what
 *           Robin rows with a feeding coefficient pass on through the entries a_ic
 *   source  max |s_i|, plus what fluxes pass on: a condition row alone lifts its point by
 *           lift_c = |value| / (sum_j |a_cj| / 2) over its neighbours, and the entries a_ic carry
 * it so that sources, data and feeding reactions may grow as they like and B grows with them.
 * Schemes whose rows are not monotone overshoot B by small factors, an unstable step by any factor:
 * SCT_GROWTH_LIMIT lies in between. */
#ifndef SCATTER_MARCH_GROWTH_H
#define SCATTER_MARCH_GROWTH_H

#include "scatter/assemble.h"

#define SCT_GROWTH_LIMIT 1e6
#define SCT_GROWTH_END 1e280 /* nothing may grow further: products would overflow */

typedef struct {
  double *lift;   /* [unknowns] condition rows: lift per value (1); equation rows: 0 */
  double growth;  /* (1 / time) of (1) */
  double carry;   /* (1 / time) largest sum_c |a_ic| */
  double source;  /* (phi / time) of (1), now */
  double earlier; /* and a step before */
  double least;   /* (phi) what conditions impose at once, dt or not */
  double bound;   /* (phi) B */
} sct_march_growth;

/* Starts with the values phi [n] and the data of the system. SCT_E_MEMORY, SCT_E_NOT_FINITE (with
 * the point). */
SCT_NODISCARD sct_status sct_march_growth_new(const sct_system *system, const double *phi,
                                              sct_march_growth *growth, sct_error *err);
void sct_march_growth_free(sct_march_growth *growth);

/* Takes in changed matrix entries, changed loads. SCT_E_NOT_FINITE. */
SCT_NODISCARD sct_status sct_march_growth_matrix(sct_march_growth *growth, const sct_system *system,
                                                 sct_error *err);
SCT_NODISCARD sct_status sct_march_growth_load(sct_march_growth *growth, const sct_system *system,
                                               sct_error *err);

/* Advances B by dt and compares phi at the new time t. SCT_E_UNSTABLE, whose text ends with
 * `advice`; SCT_E_NOT_FINITE (Dirichlet value). */
SCT_NODISCARD sct_status sct_march_growth_check(sct_march_growth *growth, const sct_system *system,
                                                const double *phi, double t, double dt,
                                                const char *advice, sct_error *err);

#endif
