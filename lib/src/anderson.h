/* anderson.h - acceleration of a fixed-point iteration x <- x + f(x) (Anderson 1965; Walker and Ni
 * 2011): of all combinations of the last steps the one whose f is least. */
#ifndef SCATTER_ANDERSON_H
#define SCATTER_ANDERSON_H

#include "scatter/status.h"

enum { SCT_ANDERSON_WINDOW = 8 };

typedef struct sct_anderson sct_anderson;

/* For x [n]. *anderson is NULL on failure. SCT_E_MEMORY: 26 n doubles. */
SCT_NODISCARD sct_status sct_anderson_new(int64_t n, sct_anderson **anderson, sct_error *err);
void sct_anderson_free(sct_anderson **anderson);

/* Forgets all steps: what follows is another problem. */
void sct_anderson_restart(sct_anderson *anderson);

/* x [n] <- the accelerated x + f, where f [n] = f(x). Cost O(n window^2). Proof: unit.anderson */
void sct_anderson_step(sct_anderson *anderson, const double *f, double *x);

#endif
