#include "limited_rows.h"

#include <math.h>
#include <string.h>

#include "alloc.h"

sct_status sct_limited_new(const sct_cloud *cloud, sct_limited **out, sct_error *err) {
  sct_limited *l = NULL;
  *out = NULL;
  sct_status status = sct_alloc_zero(&l, 1, sizeof *l, err);
  if (status != SCT_OK) return status;
  l->dim = cloud->dim;
  l->n = cloud->n;
  l->blocks = (cloud->n + SCT_POINTS_BLOCK - 1) / SCT_POINTS_BLOCK;
  status = sct_alloc(&l->x, l->n * l->dim, sizeof *l->x, err);
  if (status == SCT_OK) {
    memcpy(l->x, cloud->x, (size_t)(l->n * l->dim) * sizeof *l->x);
    status = sct_alloc_zero(&l->gradients, l->blocks, sizeof *l->gradients, err);
  }
  if (status == SCT_OK) status = sct_alloc_zero(&l->edges, l->blocks, sizeof *l->edges, err);
  if (status != SCT_OK) sct_limited_free(&l);
  *out = l;
  return status;
}

static void free_rows(limited_rows **rows, int64_t blocks) {
  for (int64_t b = 0; *rows != NULL && b < blocks; b++) {
    sct_release(&(*rows)[b].index);
    sct_release(&(*rows)[b].value);
  }
  sct_release(rows);
}

void sct_limited_free(sct_limited **limited) {
  sct_limited *l = *limited;
  if (l == NULL) return;
  free_rows(&l->gradients, l->blocks);
  free_rows(&l->edges, l->blocks);
  sct_release(&l->x);
  sct_release(limited);
}

/* Room for n more entries behind those before point i; *value is where theirs go. */
static sct_status add(limited_rows *rows, int64_t i, int width, int64_t n, const int32_t *index,
                      double **value, sct_error *err) {
  const int64_t k = i % SCT_POINTS_BLOCK, first = rows->start[k], end = first + n;
  if (end > rows->capacity) {
    const int64_t capacity = end + end / 2;
    sct_status status = sct_realloc(&rows->index, capacity, sizeof *rows->index, err);
    if (status == SCT_OK) {
      status = sct_realloc(&rows->value, capacity * width, sizeof *rows->value, err);
    }
    if (status != SCT_OK) return status;
    rows->capacity = capacity;
  }
  for (int64_t e = 0; e < n; e++) rows->index[first + e] = index[e];
  rows->start[k + 1] = end;
  *value = n > 0 ? rows->value + first * width : NULL;
  return SCT_OK;
}

sct_status sct_limited_add_edges(sct_limited *l, int64_t i, int64_t n, const int32_t *index,
                                 const double *convection, const double *pair, sct_error *err) {
  double *value;
  const sct_status status =
      add(&l->edges[i / SCT_POINTS_BLOCK], i, EDGE_WIDTH, n, index, &value, err);
  if (status != SCT_OK) return status;
  for (int64_t e = 0; e < n; e++, value += EDGE_WIDTH) {
    value[EDGE_CONVECTION] = convection == NULL ? 0 : convection[e];
    value[EDGE_NEGATIVE] = fmin(pair[e], 0);
  }
  return SCT_OK;
}

sct_status sct_limited_add_gradient(sct_limited *l, const sct_stencil *stencil, int64_t i,
                                    sct_condition condition, sct_room *room, sct_error *err) {
  static const double moving[SCT_DIM_MAX] = {1, 1, 1}; /* asks for the gradient of the edges */
  const sct_row_request request = {.want = SCT_ROW_GRADIENT | SCT_ROW_LINEAR,
                                   .velocity = condition == SCT_INTERIOR ? NULL : moving};
  sct_error why = {.code = SCT_OK};
  sct_row row = {.n = 0};
  double *value;
  sct_status status = sct_stencil_row(stencil, i, &request, room, &row, &why);
  if (status == SCT_E_DEFICIENT && condition == SCT_DIRICHLET) {
    status = SCT_OK;
    row.n = 0;
  }
  if (status != SCT_OK) {
    if (err != NULL) *err = why;
    return status;
  }
  status = add(&l->gradients[i / SCT_POINTS_BLOCK], i, l->dim, row.n, row.index, &value, err);
  if (status != SCT_OK) return status;
  for (int64_t e = 0; e < row.n; e++) {
    for (int a = 0; a < l->dim; a++) *value++ = row.gradient[a * row.n + e];
  }
  return SCT_OK;
}
