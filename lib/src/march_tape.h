/* march_tape.h - how a march fills its tape (march.h). */
#ifndef SCATTER_MARCH_TAPE_H
#define SCATTER_MARCH_TAPE_H

#include "scatter/march.h"

/* Makes room for level 0 and `steps` more. Nothing to do for a tape that is NULL, here and below.
 * SCT_E_LIMIT, SCT_E_MEMORY. */
SCT_NODISCARD sct_status sct_tape_start(sct_tape *tape, sct_march_method method,
                                        const sct_system *system, double steps, sct_error *err);

/* Appends a level: phi [n] with y [unknowns] in the place of its unknowns. */
void sct_tape_record(sct_tape *tape, const sct_system *system, double t, double dt,
                     const double *phi, const double *y);

#endif
