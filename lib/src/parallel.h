/* parallel.h - long loops: cut into pieces for the caller to hear of, and into threads. */
#ifndef SCATTER_PARALLEL_H
#define SCATTER_PARALLEL_H

#include "scatter/status.h"

/* Does something for the items first .. last-1 on thread t; writes memory of its own only. False:
 * it failed, stop. */
typedef bool sct_slice(void *context, int64_t first, int64_t last, int t);

/* Works through n items in ascending pieces of 2^17. Between pieces work->report hears of
 * `phase`; a piece is cut into at most one slice per thread, thread t getting the t-th. *complete
 * is false if a slice failed: then no piece after that one is begun. SCT_E_CANCELLED. */
SCT_NODISCARD sct_status sct_in_pieces(int64_t n, const sct_work *work, const char *phase,
                                       sct_slice *slice, void *context, bool *complete,
                                       sct_error *err);

#endif
