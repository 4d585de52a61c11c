/* partition.h - a cloud in parts, for processes that each work on one.
 *
 * Parts are stretches of the space-filling curve: part k of P owns the points at its places
 *   floor(n k / P) .. floor(n (k + 1) / P) - 1.                                          (1)
 * What a part sees of the others is its halo, the points that some row of its own may refer to:
 *   H_k = { j not in part k : |x_j - x_i| < w_i for some i in part k }                   (2)
 * with w_i the support of row i. A part keeps own points and halo in the order of the whole cloud,
 * so that its rows are those of the whole to the last bit.
 */
#ifndef SCATTER_PARTITION_H
#define SCATTER_PARTITION_H

#include "scatter/assemble.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
  int64_t n;
  int parts;
  int32_t *order; /* [n] point at a place of the curve; NULL: points are numbered along it */
  int32_t *place; /* [n] and back; NULL likewise */
} sct_partition;

/* Finds the curve, unless the points are numbered along it. SCT_E_ARGUMENT (parts < 1),
 * SCT_E_MEMORY; those of sct_cloud_order. *partition is NULL on failure. Cost O(n).
 * Proof: unit.partition */
SCT_NODISCARD sct_status sct_partition_build(const sct_cloud *cloud, int parts, bool along_curve,
                                             sct_partition **partition, sct_error *err);
void sct_partition_free(sct_partition **partition);

/* First place of part k, n for k = parts; the point at a place. */
int64_t sct_partition_start(const sct_partition *partition, int k);
int32_t sct_partition_point(const sct_partition *partition, int64_t place);

typedef struct {
  int64_t n, own;  /* points; its own among them */
  int32_t *point;  /* [n] number in the whole cloud, ascending */
  uint8_t *is_own; /* [n] */
  sct_cloud cloud; /* [n] */
  double *x;       /* [n][dim] of the cloud */
} sct_part;

/* Part k with its halo (2): w_i is `width` (length), or reach[i] (n of the whole cloud, read at own
 * points; NULL: none) where that is larger. SCT_E_MEMORY. *part is NULL on failure. Cost, for each
 * different width: O(n) comparisons with a box, and a search for those inside. Proof:
 * unit.partition (against brute force) */
SCT_NODISCARD sct_status sct_part_build(const sct_cloud *cloud, const sct_partition *partition,
                                        int k, double width, const double *reach,
                                        const sct_work *work, sct_part **part, sct_error *err);
void sct_part_free(sct_part **part);

/* The rows of part k of a system (assemble.h). Halo points stand in `system` like points with a
 * given value: columns of own unknowns are in its matrix, all others in its coupling. In the whole
 * system unknowns are numbered along the curve, so those of a part are consecutive. */
typedef struct {
  sct_part *part;
  sct_system *system; /* of the points of the part */
  int64_t unknowns;   /* of the whole system */
  int64_t first;      /* number of this part's first one */
  int32_t *number;    /* [part->n] number of an unknown, -1 for a given value */
  int rounds;         /* how often rows were made, as the halo grew */
  double wide;        /* (length) widest support of its rows */
} sct_part_system;

/* What the rows are made of, on the whole cloud. */
typedef struct {
  const sct_cloud *cloud;
  const sct_partition *partition;
  double spacing;
  const sct_operator *op; /* not upwind `limited` */
  int64_t limit;          /* neighbours of a point */
  const sct_fields *fields;
  const sct_boundary *boundary;
} sct_part_problem;

/* Assembles the rows of part k. A row that had to look beyond the halo is made again with a wider
 * one, until none had to: so every row is bit for bit that of sct_system_build on the whole cloud,
 * and so are failures, but for the list of points: SCT_E_DEFICIENT, SCT_E_LIMIT, SCT_E_COINCIDENT,
 * SCT_E_ARGUMENT (also for upwind limited), SCT_E_NOT_FINITE, SCT_E_MEMORY. Points of errors are
 * those of the whole cloud. Proof: verify.partition */
SCT_NODISCARD sct_status sct_part_assemble(const sct_part_problem *problem, int k,
                                           const sct_work *work, sct_part_system **system,
                                           sct_error *err);
void sct_part_system_free(sct_part_system **system);

#ifdef __cplusplus
}
#endif
#endif
