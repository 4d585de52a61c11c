#include "row_buffer.h"

#include "alloc.h"

static sct_status buffer_reserve(row_buffer *buffer, int64_t more, sct_error *err) {
  const int64_t needed = buffer->entries + more;
  if (needed <= buffer->capacity) return SCT_OK;
  const int64_t capacity = needed + needed / 2;
  sct_status status = sct_realloc(&buffer->column, capacity, sizeof *buffer->column, err);
  if (status == SCT_OK) status = sct_realloc(&buffer->value, capacity, sizeof *buffer->value, err);
  if (status == SCT_OK) buffer->capacity = capacity;
  return status;
}

static sct_status keys_reserve(row_buffer *buffer, int64_t needed, sct_error *err) {
  if (needed <= buffer->keys) return SCT_OK;
  const sct_status status = sct_realloc(&buffer->key, 2 * needed, sizeof *buffer->key, err);
  if (status == SCT_OK) buffer->keys = 2 * needed;
  return status;
}

/* Sorts a row by column: merges from runs of RUN upwards on keys (column, place), so that only
 * integers move; a row has 10 to 100 entries in a few ascending runs. */
enum { RUN = 8 };

static void sort_run(int64_t n, uint64_t *key) {
  for (int64_t k = 1; k < n; k++) {
    const uint64_t moving = key[k];
    int64_t at = k;
    for (; at > 0 && key[at - 1] > moving; at--) key[at] = key[at - 1];
    key[at] = moving;
  }
}

static void merge_runs(int64_t n, int64_t run, const uint64_t *from, uint64_t *to) {
  for (int64_t low = 0; low < n; low += 2 * run) {
    const int64_t middle = low + run < n ? low + run : n;
    const int64_t high = low + 2 * run < n ? low + 2 * run : n;
    int64_t a = low, b = middle;
    for (int64_t k = low; k < high; k++) {
      const bool first = a < middle && (b == high || from[a] < from[b]);
      to[k] = first ? from[a++] : from[b++];
    }
  }
}

/* Returns the sorted keys, in one of the two arrays. */
static const uint64_t *sort_keys(int64_t n, uint64_t *key, uint64_t *other) {
  for (int64_t low = 0; low < n; low += RUN) sort_run(n - low < RUN ? n - low : RUN, key + low);
  for (int64_t run = RUN; run < n; run *= 2) {
    merge_runs(n, run, key, other);
    uint64_t *const swap = key;
    key = other;
    other = swap;
  }
  return key;
}

sct_status row_buffer_append(row_buffer *buffer, int64_t i, double diagonal, int64_t n,
                             const int32_t *index, const double *weight, sct_error *err) {
  sct_status status = buffer_reserve(buffer, n + 1, err);
  if (status == SCT_OK) status = keys_reserve(buffer, 2 * (n + 1), err);
  if (status != SCT_OK) return status;
  int32_t *column = buffer->column + buffer->entries;
  double *value = buffer->value + buffer->entries;
  for (int64_t k = 0; k < n; k++) buffer->key[k] = (uint64_t)index[k] << 32 | (uint64_t)k;
  buffer->key[n] = (uint64_t)i << 32 | (uint64_t)n;
  const uint64_t *sorted = sort_keys(n + 1, buffer->key, buffer->key + n + 1);
  for (int64_t k = 0; k <= n; k++) {
    const int64_t from = (int64_t)(sorted[k] & UINT32_MAX);
    column[k] = (int32_t)(sorted[k] >> 32);
    value[k] = from == n ? diagonal : -weight[from];
  }
  buffer->length[buffer->rows++] = (int32_t)(n + 1);
  buffer->entries += n + 1;
  return SCT_OK;
}

void row_buffer_clear(row_buffer *buffer) {
  sct_release(&buffer->column);
  sct_release(&buffer->value);
  sct_release(&buffer->key);
  *buffer = (row_buffer){.rows = 0};
}
