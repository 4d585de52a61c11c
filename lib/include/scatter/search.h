/* search.h - who is near whom.
 *
 * Neighbours of point i are the points j != i with |x_j - x_i| < radius, strictly: as computed,
 * dx dx + dy dy + dz dz < radius radius. Two structures answer the same questions, to the last bit
 * alike: uniform cells with the points sorted along them, and a k-d tree for clouds whose spacing
 * varies too much for cells. Neither is made for one radius.
 */
#ifndef SCATTER_SEARCH_H
#define SCATTER_SEARCH_H

#include "scatter/cloud.h"

#ifdef __cplusplus
extern "C" {
#endif

/* AUTO takes cells, eight points to each on average. Where a point shares its cell with more than
 * 18 points on average it tries more of them, up to four cells per point (clouds on a surface,
 * with holes, with clusters); where that leaves more than 32 it takes the tree (graded clouds,
 * points far away from the others). */
typedef enum {
  SCT_SEARCH_AUTO,
  SCT_SEARCH_GRID,
  SCT_SEARCH_TREE,
  SCT_SEARCH_COUNT
} sct_search_method;

typedef struct sct_search sct_search; /* opaque; owns a sorted copy of the points */

/* Neighbour lists of all points, compressed by rows: the neighbours of i are
 * index[start[i] .. start[i+1]-1], in the order in which the search keeps its points: no order to
 * rely on, but the same in every run and for every number of threads. */
typedef struct {
  int64_t n;
  int64_t *start; /* [n+1] */
  int32_t *index; /* [start[n]] */
} sct_lists;

/* Builds the structure and checks the cloud (sct_cloud_check). `radius` >= 0 (length) is about
 * what will be asked for, 0 if not known; cells fitted to the cloud alone are within 10 % of the
 * best for every radius from 1 to 4 spacings, so at present it changes nothing. *search is NULL on
 * failure. SCT_E_ARGUMENT, SCT_E_LIMIT, SCT_E_NOT_FINITE, SCT_E_MEMORY, SCT_E_CANCELLED.
 * Cost O(n) for cells, O(n log n) for the tree, whatever the cloud.
 * Proof: unit.search (all against brute force), unit.search.edges, verify.search, fault.search */
SCT_NODISCARD sct_status sct_search_build(const sct_cloud *cloud, double radius,
                                          sct_search_method method, const sct_work *work,
                                          sct_search **search, sct_error *err);
void sct_search_free(sct_search **search);

/* What was built: SCT_SEARCH_GRID or SCT_SEARCH_TREE; and the names "auto", "grid", "tree". */
sct_search_method sct_search_kind(const sct_search *search);
const char *sct_search_method_name(sct_search_method method);

/* Lists of all points. radius (length) for all, or radii [n] one per point where not NULL (then
 * the list of i holds |x_j - x_i| < radii[i]); infinity is a radius. *lists is NULL on failure.
 * SCT_E_ARGUMENT for a radius that is negative or NaN (with the point, for radii); SCT_E_LIMIT,
 * without finding the rest first, for more than `limit` neighbours of a point (with the point) or
 * 2^40 in all; SCT_E_MEMORY, SCT_E_CANCELLED.
 * Cost O(n + entries). Threads of `work` share the points. Memory: the lists twice, for a while.
 * Proof: unit.search, unit.search.edges (limits, threads), verify.search (cost), fault.search */
SCT_NODISCARD sct_status sct_search_lists(const sct_search *search, double radius,
                                          const double *radii, int64_t limit, const sct_work *work,
                                          sct_lists **lists, sct_error *err);
void sct_lists_free(sct_lists **lists);

/* Points with |x_j - x| < radius around any position x [dim], the point there itself included if
 * there is one. Writes up to `capacity` of them to `index` and returns how many there are (which
 * may be more). A radius or position that is NaN has none. Reads only and allocates nothing:
 * threads may ask together. Proof: unit.search */
int64_t sct_search_around(const sct_search *search, const double *x, double radius,
                          int64_t capacity, int32_t *index);

/* Distance from every point to its nearest other point: distance [n] out (infinity if n = 1).
 * SCT_E_COINCIDENT if points are at the same place: err->points has the lowest such point, those
 * that it shares its place with, the next, and so on; err->count how many points share a place;
 * their distance is 0. SCT_E_MEMORY, SCT_E_CANCELLED. Cost O(n), tree O(n log n).
 * Proof: unit.search, unit.search.edges (coincident points), fault.search */
SCT_NODISCARD sct_status sct_search_nearest(const sct_search *search, const sct_work *work,
                                            double *distance, sct_error *err);

/* The median of `value` [n], which is left as it was; n even: the mean of the two middle ones.
 * For the spacing of a cloud: the median of its nearest-neighbour distances. SCT_E_ARGUMENT for
 * n < 1. Cost O(n), no memory. Proof: unit.median */
SCT_NODISCARD sct_status sct_median(const double *value, int64_t n, double *median, sct_error *err);

#ifdef __cplusplus
}
#endif
#endif
