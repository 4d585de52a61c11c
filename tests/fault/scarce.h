/* scarce.h - memory that runs out when a test says so.
 *
 * Link with --wrap for malloc, calloc, realloc, aligned_alloc and posix_memalign (CMakeLists.txt):
 * allocations of our own code then come through here; those of shared libraries do not.
 */
#ifndef SCARCE_H
#define SCARCE_H

#include <stdbool.h>
#include <stdint.h>

/* From now on the allocation after `granted` more fails, and if `lasting` all those after it. */
void scarce_after(int64_t granted, bool lasting);

/* Ends scarcity; true if an allocation has failed. */
bool scarce_end(void);

/* Allocations asked for since scarce_after. */
int64_t scarce_count(void);

#endif
