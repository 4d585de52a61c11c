/* radix.h - sorting whole numbers in linear time. */
#ifndef SCATTER_RADIX_H
#define SCATTER_RADIX_H

#include "scatter/status.h"

/* order [n] out: the numbers 0 .. n-1 by ascending key [n], equal keys by ascending number. Only
 * the lowest `bits` bits of the keys are looked at. The keys are left sorted too.
 * SCT_E_MEMORY. Cost O(n * bits / 11). Proof: unit.cloud.radix */
SCT_NODISCARD sct_status sct_radix_sort(uint64_t *key, int64_t n, int bits, int32_t *order,
                                        sct_error *err);

/* A double as a whole number that sorts like it: -inf < ... < -0 < 0 < ... < inf < NaN. */
uint64_t sct_radix_key(double value);
double sct_radix_value(uint64_t key);

#endif
