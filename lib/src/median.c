#include "radix.h"
#include "scatter/search.h"

/* Radix selection: the digits of the key of `rank` (0: the least) are fixed one after the other,
 * the highest first, by counting the values that share the digits fixed so far. No memory, no bad
 * case. */
static double select_rank(const double *value, int64_t n, int64_t rank) {
  enum { DIGIT = 8, BUCKETS = 1 << DIGIT };
  uint64_t prefix = 0;
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
  return sct_radix_value(prefix);
}

/* The value that follows `low`, which `rank` values precede, in ascending order: low itself where
 * it is there once more. */
static double next_value(const double *value, int64_t n, int64_t rank, double low) {
  const uint64_t floor = sct_radix_key(low);
  uint64_t next = UINT64_MAX;
  int64_t up_to = 0;
  for (int64_t i = 0; i < n; i++) {
    const uint64_t key = sct_radix_key(value[i]);
    if (key <= floor) up_to++;
    if (key > floor && key < next) next = key;
  }
  return up_to > rank + 1 ? low : sct_radix_value(next);
}

sct_status sct_median(const double *value, int64_t n, double *median, sct_error *err) {
  if (n < 1) return sct_fail(err, SCT_E_ARGUMENT, -1, "there is no median of no values");
  const int64_t rank = (n - 1) / 2;
  const double low = select_rank(value, n, rank);
  const double high = n % 2 == 0 ? next_value(value, n, rank, low) : low;
  *median = low == high ? low : 0.5 * low + 0.5 * high; /* their sum might overflow */
  return SCT_OK;
}
