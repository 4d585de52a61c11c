#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "alloc.h"
#include "scatter/cloud.h"

static int64_t along(const sct_lattice *lattice, int k) {
  return k < lattice->dim ? lattice->cells[k] + 1 : 1;
}

static double extent(const sct_lattice *lattice, int k) {
  return lattice->upper[k] - lattice->lower[k];
}

static sct_status check_axis(const sct_lattice *lattice, int k, sct_error *err) {
  double lower = lattice->lower[k], upper = lattice->upper[k];
  int64_t cells = lattice->cells[k];
  if (cells < 1) {
    return sct_fail(err, SCT_E_ARGUMENT, -1,
                    "lattice has %" PRId64 " cells along axis %d, needs at least 1", cells, k);
  }
  if (!isfinite(lower) || !(lower < upper) || !isfinite((upper - lower) * (double)cells)) {
    return sct_fail(err, SCT_E_ARGUMENT, -1,
                    "box is [%g, %g] along axis %d, needs a finite lower < upper", lower, upper, k);
  }
  return SCT_OK;
}

static sct_status check_count(const sct_lattice *lattice, sct_error *err) {
  int64_t count = 1;
  for (int k = 0; k < lattice->dim; k++) {
    if (lattice->cells[k] >= SCT_POINTS_MAX / count) {
      return sct_fail(err, SCT_E_LIMIT, -1, "lattice has more than %" PRId64 " points",
                      SCT_POINTS_MAX);
    }
    count *= along(lattice, k);
  }
  return SCT_OK;
}

sct_status sct_lattice_check(const sct_lattice *lattice, sct_error *err) {
  if (lattice == NULL) return sct_fail(err, SCT_E_ARGUMENT, -1, "there is no lattice");
  if (lattice->dim < 1 || lattice->dim > SCT_DIM_MAX) {
    return sct_fail(err, SCT_E_ARGUMENT, -1, "dimension is %d, needs 1 to 3", lattice->dim);
  }
  if (!(lattice->jitter >= 0 && lattice->jitter < 1)) {
    return sct_fail(err, SCT_E_ARGUMENT, -1, "jitter is %g, needs to be in [0, 1)",
                    lattice->jitter);
  }
  for (int k = 0; k < lattice->dim; k++) {
    sct_status status = check_axis(lattice, k, err);
    if (status != SCT_OK) return status;
  }
  return check_count(lattice, err);
}

int64_t sct_lattice_count(const sct_lattice *lattice) {
  return along(lattice, 0) * along(lattice, 1) * along(lattice, 2);
}

static double step(const sct_lattice *lattice, int k) {
  return extent(lattice, k) / (double)lattice->cells[k];
}

double sct_lattice_spacing(const sct_lattice *lattice) {
  double first = step(lattice, 0), product = 1;
  bool same = true;
  for (int k = 0; k < lattice->dim; k++) {
    double h = step(lattice, k);
    same = same && h == first;
    product *= pow(h, 1.0 / lattice->dim); /* root before product: no overflow */
  }
  return same ? first : product;
}

/* SplitMix64 as a function of the draw number: see cloud.h. */
static double chi(uint64_t seed, uint64_t draw) {
  uint64_t z = seed + (draw + 1) * UINT64_C(0x9e3779b97f4a7c15);
  z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
  z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
  z ^= z >> 31;
  return (double)(z >> 11) * 0x1p-53;
}

static double place(const sct_lattice *lattice, int k, int64_t i) {
  if (i == lattice->cells[k]) return lattice->upper[k];
  return lattice->lower[k] + extent(lattice, k) * (double)i / (double)lattice->cells[k];
}

static bool is_inner(const sct_lattice *lattice, const int64_t *i) {
  for (int k = 0; k < lattice->dim; k++) {
    if (i[k] == 0 || i[k] == lattice->cells[k]) return false;
  }
  return true;
}

/* Next place i [3] of the lattice, x fastest. */
static void advance(const sct_lattice *lattice, int64_t *i) {
  for (int k = 0; k < lattice->dim; k++) {
    if (++i[k] < along(lattice, k)) return;
    i[k] = 0;
  }
}

void sct_lattice_points(const sct_lattice *lattice, double *x) {
  int64_t count = sct_lattice_count(lattice), i[SCT_DIM_MAX] = {0};
  uint64_t draw = 0;
  for (int64_t p = 0; p < count; p++, advance(lattice, i)) {
    bool moves = is_inner(lattice, i) && lattice->jitter > 0;
    for (int k = 0; k < lattice->dim; k++, x++) {
      *x = place(lattice, k, i[k]);
      if (moves) *x += lattice->jitter * (chi(lattice->seed, draw++) - 0.5) * step(lattice, k);
    }
  }
}

/* The two sides of axis k are 2k (low) and 2k + 1 (high). */
static const char *const side_names[SCT_SIDE_COUNT] = {"left", "right", "bottom",   "top",
                                                       "back", "front", "boundary", "interior"};

const char *sct_side_name(sct_side side) {
  return (unsigned)side < SCT_SIDE_COUNT ? side_names[side] : NULL;
}

sct_side sct_side_find(const char *name) {
  int side = 0;
  while (side < SCT_SIDE_COUNT && (name == NULL || strcmp(name, side_names[side]) != 0)) side++;
  return (sct_side)side;
}

/* Sum of the outward normals of the sides that place i lies on; their number. */
static int normal_sum(const sct_lattice *lattice, const int64_t *i, double *sum) {
  int sides = 0;
  for (int k = 0; k < lattice->dim; k++) {
    int low = i[k] == 0, high = i[k] == lattice->cells[k];
    sum[k] = high - low;
    sides += high + low;
  }
  return sides;
}

static bool is_member(const sct_lattice *lattice, sct_side side, const int64_t *i) {
  if (side == SCT_SIDE_INTERIOR) return is_inner(lattice, i);
  if (side == SCT_SIDE_BOUNDARY) return !is_inner(lattice, i);
  int k = side / 2;
  return i[k] == (side % 2 == 0 ? 0 : lattice->cells[k]);
}

static int64_t interior_count(const sct_lattice *lattice) {
  int64_t count = 1;
  for (int k = 0; k < lattice->dim; k++) count *= lattice->cells[k] - 1;
  return count;
}

static int64_t member_count(const sct_lattice *lattice, sct_side side) {
  if (side == SCT_SIDE_INTERIOR) return interior_count(lattice);
  int64_t count = sct_lattice_count(lattice);
  if (side == SCT_SIDE_BOUNDARY) return count - interior_count(lattice);
  return count / along(lattice, side / 2);
}

static int64_t normal_count(sct_side side, int64_t members) {
  if (side == SCT_SIDE_INTERIOR) return 0;
  return side == SCT_SIDE_BOUNDARY ? members : 1;
}

static void fill_group(const sct_lattice *lattice, sct_side side, sct_group *group) {
  int64_t count = sct_lattice_count(lattice), i[SCT_DIM_MAX] = {0}, m = 0;
  for (int64_t p = 0; p < count; p++, advance(lattice, i)) {
    if (!is_member(lattice, side, i)) continue;
    group->index[m] = (int32_t)p;
    if (side == SCT_SIDE_BOUNDARY) {
      double *normal = group->normal + m * lattice->dim;
      double length = sqrt(normal_sum(lattice, i, normal));
      for (int k = 0; k < lattice->dim; k++) normal[k] /= length;
    }
    m++;
  }
  if (side >= SCT_SIDE_BOUNDARY) return;
  for (int k = 0; k < lattice->dim; k++) group->normal[k] = 0;
  group->normal[side / 2] = side % 2 == 0 ? -1 : 1;
}

sct_status sct_lattice_group(const sct_lattice *lattice, sct_side side, sct_group *group,
                             sct_error *err) {
  memset(group, 0, sizeof *group);
  sct_status status = sct_lattice_check(lattice, err);
  if (status != SCT_OK) return status;
  if ((unsigned)side >= SCT_SIDE_COUNT ||
      (side < SCT_SIDE_BOUNDARY && (int)side / 2 >= lattice->dim)) {
    const char *name = sct_side_name(side);
    return sct_fail(err, SCT_E_ARGUMENT, -1, "a lattice in %d dimensions has no side %s",
                    lattice->dim, name != NULL ? name : "of that number");
  }
  group->name = side_names[side];
  group->n = member_count(lattice, side);
  group->normals = normal_count(side, group->n);
  status = sct_alloc(&group->index, group->n, sizeof *group->index, err);
  if (status == SCT_OK && group->normals > 0) {
    status = sct_alloc(&group->normal, group->normals * lattice->dim, sizeof(double), err);
  }
  if (status == SCT_OK) {
    fill_group(lattice, side, group);
  } else {
    sct_group_clear(group);
  }
  return status;
}

void sct_group_clear(sct_group *group) {
  if (group == NULL) return;
  sct_release(&group->index);
  sct_release(&group->normal);
  memset(group, 0, sizeof *group);
}
