/* cloud.h - points: views of posted ones, lattices with jitter, groups with normals.
 *
 * A cloud is a view: it borrows the caller's coordinates x[n][dim], row-major, and never
 * outlives the call it is passed to. Points are numbered 0 .. n-1 in the caller's order.
 */
#ifndef SCATTER_CLOUD_H
#define SCATTER_CLOUD_H

#include "scatter/status.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { SCT_DIM_MAX = 3 };

/* Point numbers inside lists and matrices are int32_t: half the memory traffic. */
#define SCT_POINTS_MAX ((int64_t)INT32_MAX - 1)

typedef struct {
  int dim;         /* 1, 2 or 3 */
  int64_t n;       /* number of points */
  const double *x; /* [n][dim] coordinates (length) */
} sct_cloud;

/* Checks dim in 1..3, 1 <= n <= SCT_POINTS_MAX, x not NULL and every coordinate finite.
 * SCT_E_ARGUMENT, SCT_E_LIMIT; SCT_E_NOT_FINITE with err->point the first culprit.
 * Coincident points are found by sct_search_nearest, which has to look at pairs anyway.
 * Cost O(n). Proof: unit.cloud */
SCT_NODISCARD sct_status sct_cloud_check(const sct_cloud *cloud, sct_error *err);

/* Order along the Hilbert curve: place k belongs to point order[k], order [n] out. Everything that
 * follows (lists, rows, factors) runs through memory in the order of its points: for a million
 * points in random order a sweep over lists takes nine times as long. A lattice's own order is as
 * good as the curve's. Checks the cloud; SCT_E_MEMORY. Cost O(n). Proof: unit.cloud */
SCT_NODISCARD sct_status sct_cloud_order(const sct_cloud *cloud, int32_t *order, sct_error *err);

/* A lattice of (cells[0]+1) x (cells[1]+1) x ... points on the box [lower, upper], numbered x
 * fastest. Points strictly inside the box are displaced by jitter * (chi - 1/2) * h_k in
 * coordinate k, chi uniform in [0, 1), h_k the lattice step of that coordinate; boundary points
 * stay put ([H16] section 4). chi comes from SplitMix64 (Steele, Lea and Flood 2014) as a counter
 * generator: draw number m = (running number of the interior point) * dim + k is
 * mix(seed + (m + 1) * G) >> 11, times 2^-53, modulo 2^64, with G = 0x9e3779b97f4a7c15 and
 *   mix(z): z = (z ^ z>>30) * 0xbf58476d1ce4e5b9; z = (z ^ z>>27) * 0x94d049bb133111eb; z ^ z>>31
 * so a cloud is the same on every machine, whatever the number of threads. */
typedef struct {
  int dim;
  double lower[SCT_DIM_MAX], upper[SCT_DIM_MAX]; /* corners of the box (length) */
  int64_t cells[SCT_DIM_MAX];                    /* cells per side, >= 1 */
  double jitter;                                 /* alpha in [0, 1) */
  uint64_t seed;
} sct_lattice;

/* SCT_E_ARGUMENT for a dimension, box (lower < upper, finite, and so is extent * cells), cell
 * count or jitter that is not one; SCT_E_LIMIT for more than SCT_POINTS_MAX points. Proof:
 * unit.lattice */
SCT_NODISCARD sct_status sct_lattice_check(const sct_lattice *lattice, sct_error *err);

/* Number of points of a checked lattice. */
int64_t sct_lattice_count(const sct_lattice *lattice);

/* Lattice step; the geometric mean of the steps where they differ. */
double sct_lattice_spacing(const sct_lattice *lattice);

/* Coordinates of a checked lattice. x [count][dim] out. A jitter of 0 gives
 * x = lower + (upper - lower) * i / cells, with both ends exact. Proof: unit.lattice */
void sct_lattice_points(const sct_lattice *lattice, double *x);

/* Groups of a lattice, in this order. In 1-D left, right; in 2-D also bottom, top (y); in 3-D
 * also back, front (z). `boundary` is their union, `interior` the rest. */
typedef enum {
  SCT_SIDE_LEFT,
  SCT_SIDE_RIGHT,
  SCT_SIDE_BOTTOM,
  SCT_SIDE_TOP,
  SCT_SIDE_BACK,
  SCT_SIDE_FRONT,
  SCT_SIDE_BOUNDARY,
  SCT_SIDE_INTERIOR,
  SCT_SIDE_COUNT
} sct_side;

/* Name of a side ("left"), NULL out of range; and back, SCT_SIDE_COUNT if unknown. */
const char *sct_side_name(sct_side side);
sct_side sct_side_find(const char *name);

/* A set of points with a name. `normal` is NULL, or one outward unit normal for all ([dim]) or
 * one per point ([n][dim]), as `normals` (0, 1 or n) says. */
typedef struct {
  const char *name;
  int64_t n;
  int32_t *index; /* [n] ascending */
  double *normal; /* [normals][dim] */
  int64_t normals;
} sct_group;

/* Builds the group of a lattice side: its points and their outward normal; corner and edge points
 * belong to every side they touch; in `boundary` each point has the normalised sum of its sides'
 * normals; `interior` has none. A side the dimension does not have: SCT_E_ARGUMENT.
 * Free with sct_group_clear. Proof: unit.lattice */
SCT_NODISCARD sct_status sct_lattice_group(const sct_lattice *lattice, sct_side side,
                                           sct_group *group, sct_error *err);

/* Frees what a group owns and zeroes it. */
void sct_group_clear(sct_group *group);

#ifdef __cplusplus
}
#endif
#endif
