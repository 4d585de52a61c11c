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

/* Behind the neighbours with a lower number comes the point itself. */
sct_status row_buffer_append(row_buffer *buffer, int64_t i, double diagonal, int64_t n,
                             const int32_t *index, const double *weight, sct_error *err) {
  sct_status status = buffer_reserve(buffer, n + 1, err);
  if (status != SCT_OK) return status;
  int32_t *column = buffer->column + buffer->entries;
  double *value = buffer->value + buffer->entries;
  int64_t k = 0;
  for (; k < n && index[k] < i; k++) {
    column[k] = index[k];
    value[k] = -weight[k];
  }
  column[k] = (int32_t)i;
  value[k] = diagonal;
  for (; k < n; k++) {
    column[k + 1] = index[k];
    value[k + 1] = -weight[k];
  }
  buffer->length[buffer->rows++] = (int32_t)(n + 1);
  buffer->entries += n + 1;
  return SCT_OK;
}

void row_buffer_clear(row_buffer *buffer) {
  sct_release(&buffer->column);
  sct_release(&buffer->value);
  *buffer = (row_buffer){.rows = 0};
}
