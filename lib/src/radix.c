/* Least significant digit first, 11 bits a time: 2048 counters stay in the first-level cache. */
#include "radix.h"

#include <string.h>

#include "alloc.h"

enum { DIGIT = 11, BUCKETS = 1 << DIGIT };

typedef struct {
  uint64_t *key;
  int32_t *item;
} column;

/* first[b] = place of the first key whose digit is b. False if one digit is all there is. */
static bool places(const uint64_t *key, int64_t n, int shift, int64_t *first) {
  memset(first, 0, BUCKETS * sizeof *first);
  for (int64_t k = 0; k < n; k++) first[(key[k] >> shift) & (BUCKETS - 1)]++;
  int64_t sum = 0;
  for (int b = 0; b < BUCKETS; b++) {
    int64_t count = first[b];
    if (count == n) return false;
    first[b] = sum;
    sum += count;
  }
  return true;
}

static void move(column from, column to, int64_t n, int shift, int64_t *first) {
  for (int64_t k = 0; k < n; k++) {
    int64_t place = first[(from.key[k] >> shift) & (BUCKETS - 1)]++;
    to.key[place] = from.key[k];
    to.item[place] = from.item[k];
  }
}

sct_status sct_radix_sort(uint64_t *key, int64_t n, int bits, int32_t *order, sct_error *err) {
  column from = {key, order}, to = {NULL, NULL};
  int64_t first[BUCKETS];
  sct_status status = sct_alloc(&to.key, n, sizeof *to.key, err);
  if (status == SCT_OK) status = sct_alloc(&to.item, n, sizeof *to.item, err);
  column spare = to;
  if (status != SCT_OK) goto done;
  for (int64_t k = 0; k < n; k++) order[k] = (int32_t)k;
  for (int shift = 0; shift < bits; shift += DIGIT) {
    if (!places(from.key, n, shift, first)) continue;
    move(from, to, n, shift, first);
    column swap = from;
    from = to;
    to = swap;
  }
  if (from.item != order) {
    memcpy(key, from.key, (size_t)n * sizeof *key);
    memcpy(order, from.item, (size_t)n * sizeof *order);
  }
done:
  sct_release(&spare.key);
  sct_release(&spare.item);
  return status;
}

static const uint64_t sign = UINT64_C(1) << 63;

uint64_t sct_radix_key(double value) {
  uint64_t bits;
  memcpy(&bits, &value, sizeof bits);
  return bits & sign ? ~bits : bits | sign;
}

double sct_radix_value(uint64_t key) {
  double value;
  key = key & sign ? key & ~sign : ~key;
  memcpy(&value, &key, sizeof value);
  return value;
}
