#include "scatter/cloud.h"

#include <inttypes.h>
#include <math.h>

#include "alloc.h"
#include "radix.h"

static sct_status check_finite(const sct_cloud *cloud, sct_error *err) {
  int64_t entries = cloud->n * cloud->dim;
  for (int64_t e = 0; e < entries; e++) {
    if (isfinite(cloud->x[e])) continue;
    int64_t point = e / cloud->dim;
    return sct_fail(err, SCT_E_NOT_FINITE, point, "has %g as coordinate %d, needs a finite number",
                    cloud->x[e], (int)(e % cloud->dim));
  }
  return SCT_OK;
}

sct_status sct_cloud_check(const sct_cloud *cloud, sct_error *err) {
  if (cloud == NULL) return sct_fail(err, SCT_E_ARGUMENT, -1, "there is no cloud");
  if (cloud->dim < 1 || cloud->dim > SCT_DIM_MAX) {
    return sct_fail(err, SCT_E_ARGUMENT, -1, "dimension is %d, needs 1 to 3", cloud->dim);
  }
  if (cloud->n < 1) {
    return sct_fail(err, SCT_E_ARGUMENT, -1, "cloud has %" PRId64 " points, needs at least 1",
                    cloud->n);
  }
  if (cloud->n > SCT_POINTS_MAX) {
    return sct_fail(err, SCT_E_LIMIT, -1, "cloud has %" PRId64 " points, at most %" PRId64,
                    cloud->n, SCT_POINTS_MAX);
  }
  if (cloud->x == NULL) return sct_fail(err, SCT_E_ARGUMENT, -1, "cloud has no coordinates");
  return check_finite(cloud, err);
}

/* -- order along the Hilbert curve ------------------------------------------------------------- */

/* A cube around the cloud, cut into 2^bits cells per side. */
typedef struct {
  int dim, bits;
  double lower[SCT_DIM_MAX], cells_per_length;
} cube;

/* Fine enough that most points have a cell of their own. */
static int bits_of(const sct_cloud *cloud) {
  int bits = 0;
  while (cloud->n >> (bits * cloud->dim) != 0) bits++;
  return bits + 2 < 31 ? bits + 2 : 31;
}

static cube cube_of(const sct_cloud *cloud) {
  cube c = {.dim = cloud->dim, .bits = bits_of(cloud)};
  double longest = 0;
  for (int k = 0; k < cloud->dim; k++) {
    double lower = cloud->x[k], upper = lower;
    for (int64_t i = 1; i < cloud->n; i++) {
      double x = cloud->x[i * cloud->dim + k];
      if (x < lower) lower = x;
      if (x > upper) upper = x;
    }
    c.lower[k] = lower;
    longest = fmax(longest, upper / 2 - lower / 2); /* halves: the whole may overflow */
  }
  c.cells_per_length = longest > 0 ? ldexp(1, c.bits - 1) / longest : 0;
  return c;
}

static void cell_of(const cube *c, const double *x, uint32_t *cell) {
  double last = ldexp(1, c->bits) - 1;
  for (int k = 0; k < c->dim; k++) {
    double place = (x[k] / 2 - c->lower[k] / 2) * c->cells_per_length * 2;
    cell[k] = (uint32_t)(place < last ? place : last);
  }
}

/* Number of a cell along the Hilbert curve (J. Skilling, AIP Conf. Proc. 707 (2004) 381). Against
 * the Morton order, measured on 1e6 points, sweeps over neighbour lists gain 2 to 13 %, and the
 * ordering takes 30 ns more per point, once. From the coarsest bit on, the sub-cube is reflected or
 * two of its axes are exchanged, which leaves a Gray code; its bits, interleaved, are the number.
 * In one dimension the curve is the line. */
static uint64_t hilbert(int dim, int bits, uint32_t *cell) {
  uint32_t turn = 0;
  for (int b = bits - 1; b > 0 && dim > 1; b--) {
    uint32_t low = (UINT32_C(1) << b) - 1;
    for (int k = 0; k < dim; k++) {
      uint32_t set = -(cell[k] >> b & 1), swap = (cell[0] ^ cell[k]) & low & ~set;
      cell[0] ^= swap ^ (low & set);
      cell[k] ^= swap;
    }
  }
  for (int k = 1; k < dim; k++) cell[k] ^= cell[k - 1];
  for (int b = bits - 1; b > 0 && dim > 1; b--) {
    turn ^= -(cell[dim - 1] >> b & 1) & ((UINT32_C(1) << b) - 1);
  }
  uint64_t number = 0;
  for (int b = bits - 1; b >= 0; b--) {
    for (int k = 0; k < dim; k++) number = number << 1 | ((cell[k] ^ turn) >> b & 1);
  }
  return number;
}

sct_status sct_cloud_order(const sct_cloud *cloud, int32_t *order, sct_error *err) {
  uint64_t *key = NULL;
  sct_status status = sct_cloud_check(cloud, err);
  if (status == SCT_OK) status = sct_alloc(&key, cloud->n, sizeof *key, err);
  if (status != SCT_OK) return status;
  cube c = cube_of(cloud);
  for (int64_t i = 0; i < cloud->n; i++) {
    uint32_t cell[SCT_DIM_MAX] = {0};
    cell_of(&c, cloud->x + i * c.dim, cell);
    key[i] = hilbert(c.dim, c.bits, cell);
  }
  status = sct_radix_sort(key, cloud->n, c.dim * c.bits, order, err);
  sct_release(&key);
  return status;
}
