/* report.h - the output `report`, which every process has. */
#ifndef SCATTERD_REPORT_H
#define SCATTERD_REPORT_H

#include "emit.h"
#include "task.h"

/* Starts the measuring of memory over, where the kernel can (Linux with /proc). */
void report_begin(void);

/* {"version","threads","seconds":{..},"ranks":{..},"memory_estimate_bytes","memory_peak_bytes"}.
 * `decode` is all until the inputs are checked, fields evaluated; `stencil` includes diagnostics;
 * `encode` is the time of the outputs before this one, `total` the time up to here; the peak is the
 * largest the worker has had since the request began, what it keeps from requests before among it.
 */
void report_write(emit *e, const task *t, const void *state);

#endif
