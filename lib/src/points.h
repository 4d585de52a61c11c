/* points.h - one loop over all points, shared by threads, for whatever is done with rows. */
#ifndef SCATTER_POINTS_H
#define SCATTER_POINTS_H

#include "scatter/stencil.h"

/* Work on point i by the thread that owns `room`. Results that must be put together in the order
 * of the points go by block, (i - first) / SCT_POINTS_BLOCK: one thread does the points of a block,
 * in order. */
typedef sct_status sct_points_work(void *context, int64_t i, sct_room *room, sct_error *err);

enum { SCT_POINTS_BLOCK = 256 };

/* Runs `work_on` over the points first .. end-1. Deficient points do not stop the others: the
 * failure of the lowest one is returned with all of them in its list. Any other failure stops, and
 * outranks deficiency. The result does not depend on the number of threads.
 * SCT_E_MEMORY for the rooms. */
SCT_NODISCARD sct_status sct_points_run(const sct_stencil *stencil, int64_t first, int64_t end,
                                        const sct_work *work, sct_points_work *work_on,
                                        void *context, sct_error *err);

#endif
