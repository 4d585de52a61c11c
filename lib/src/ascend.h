/* ascend.h - short lists of point numbers put in order. */
#ifndef SCATTER_ASCEND_H
#define SCATTER_ASCEND_H

#include <stdint.h>

/* Sorts index [n]; other [n] is scratch. Made for what searches give: 10 to 100 numbers in a few
 * ascending runs. Cost O(n log n). Proof: unit.ascend */
void sct_ascend(int64_t n, int32_t *index, int32_t *other);

#endif
