/* report.h - the output `report`, which every process has. */
#ifndef SCATTERD_REPORT_H
#define SCATTERD_REPORT_H

#include "emit.h"
#include "task.h"

/* {"version","threads","seconds":{..},"memory_peak_bytes"}. `decode` is all until the inputs are
 * checked, fields evaluated; `stencil` includes diagnostics; `encode` is the time of the outputs
 * before this one, `total` the time up to here; memory is the largest the worker has had since it
 * started. */
void report_write(emit *e, const task *t, const void *state);

#endif
