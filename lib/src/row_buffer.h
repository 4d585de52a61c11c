/* row_buffer.h - matrix rows in the making: those of one block of points, sorted by column. */
#ifndef SCATTER_ROW_BUFFER_H
#define SCATTER_ROW_BUFFER_H

#include "points.h"

typedef struct {
  int64_t rows, entries, capacity;
  int32_t length[SCT_POINTS_BLOCK]; /* entries of each row */
  int32_t *column;
  double *value;
} row_buffer;

/* Appends the row diagonal phi_i - sum_j weight_j phi_j over the n neighbours `index`,
 * ascending; the caller has put sum_j weight_j into the diagonal. SCT_E_MEMORY. */
SCT_NODISCARD sct_status row_buffer_append(row_buffer *buffer, int64_t i, double diagonal,
                                           int64_t n, const int32_t *index, const double *weight,
                                           sct_error *err);

/* Frees what it owns. */
void row_buffer_clear(row_buffer *buffer);

#endif
