#include "radix.h"
#include "scatter/search.h"

/* Radix selection: the digits of the median's key are fixed one after the other, the highest
 * first, by counting the values that share the digits fixed so far. No memory, no bad case. */
sct_status sct_median(const double *value, int64_t n, double *median, sct_error *err) {
  enum { DIGIT = 8, BUCKETS = 1 << DIGIT };
  if (n < 1) return sct_fail(err, SCT_E_ARGUMENT, -1, "there is no median of no values");
  uint64_t prefix = 0;
  int64_t rank = (n - 1) / 2;
  for (int shift = 64 - DIGIT; shift >= 0; shift -= DIGIT) {
    int64_t count[BUCKETS] = {0};
    for (int64_t i = 0; i < n; i++) {
      uint64_t key = sct_radix_key(value[i]) >> shift;
      if (key >> DIGIT == prefix) count[key & (BUCKETS - 1)]++;
    }
    uint64_t digit = 0;
    while (rank >= count[digit]) rank -= count[digit++];
    prefix = prefix << DIGIT | digit;
  }
  *median = sct_radix_value(prefix);
  return SCT_OK;
}
