/* search.h - who is near whom.
 *
 * Neighbours of point i are the points j != i with |x_j - x_i| < radius, strictly.
 * Two structures answer the same questions: uniform cells with the points sorted along them, and a
 * k-d tree for clouds whose spacing varies too much for cells. SCT_SEARCH_AUTO chooses.
 */
#ifndef SCATTER_SEARCH_H
#define SCATTER_SEARCH_H

#include "scatter/cloud.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
  SCT_SEARCH_AUTO,
  SCT_SEARCH_GRID,
  SCT_SEARCH_TREE,
  SCT_SEARCH_COUNT
} sct_search_method;

typedef struct sct_search sct_search; /* opaque; owns a sorted copy of the points */

/* Neighbour lists of all points, compressed by rows: the neighbours of i are
 * index[start[i] .. start[i+1]-1], in no particular but reproducible order, the same for every
 * number of threads. */
typedef struct {
  int64_t n;
  int64_t *start; /* [n+1] */
  int32_t *index; /* [start[n]] */
} sct_lists;

/* Builds the structure. `radius` is the radius most questions will be about (length); 0 if not
 * known yet. Checks the cloud (sct_cloud_check). *search is NULL on failure.
 * SCT_E_ARGUMENT, SCT_E_LIMIT, SCT_E_NOT_FINITE, SCT_E_MEMORY. Cost O(n) cells, O(n log n) tree.
 * Proof: unit.search (grid, tree and auto against brute force), verify.search.linear */
SCT_NODISCARD sct_status sct_search_build(const sct_cloud *cloud, double radius,
                                          sct_search_method method, const sct_work *work,
                                          sct_search **search, sct_error *err);
void sct_search_free(sct_search **search);

/* What was built: SCT_SEARCH_GRID or SCT_SEARCH_TREE; and the names "auto", "grid", "tree". */
sct_search_method sct_search_kind(const sct_search *search);
const char *sct_search_method_name(sct_search_method method);

/* Lists of all points. radius (length) for all, or radii [n] one per point where not NULL (then
 * the list of i holds |x_j - x_i| < radii[i]). At most `limit` neighbours of one point and
 * 2^40 in all (SCT_E_LIMIT with the point). *lists is NULL on failure.
 * Cost O(n + entries). Threads of `work` share the points. Proof: unit.search */
SCT_NODISCARD sct_status sct_search_lists(const sct_search *search, double radius,
                                          const double *radii, int64_t limit, const sct_work *work,
                                          sct_lists **lists, sct_error *err);
void sct_lists_free(sct_lists **lists);

/* Points with |x_j - x| < radius around any position x [dim], the point there itself included if
 * there is one. Writes up to `capacity` of them and returns how many there are (which may be
 * more). Reads only: threads may ask together. Proof: unit.search */
int64_t sct_search_around(const sct_search *search, const double *x, double radius,
                          int64_t capacity, int32_t *index);

/* Distance from every point to its nearest other point: distance [n] out (infinity if n = 1).
 * Two points at the same place are SCT_E_COINCIDENT with both numbers in err->points, lowest pair
 * first. Cost O(n). Proof: unit.search */
SCT_NODISCARD sct_status sct_search_nearest(const sct_search *search, const sct_work *work,
                                            double *distance, sct_error *err);

/* The median of `value` [n], which is left as it was. For the spacing of a cloud: the median of
 * its nearest-neighbour distances. n even: the lower of the two middle ones. SCT_E_MEMORY,
 * SCT_E_ARGUMENT for n < 1. Cost O(n). Proof: unit.search */
SCT_NODISCARD sct_status sct_median(const double *value, int64_t n, double *median, sct_error *err);

#ifdef __cplusplus
}
#endif
#endif
