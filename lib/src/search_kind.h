/* search_kind.h - what cells and tree have in common.
 *
 * Both structures put the points into an order of their own in which the points near any box are
 * a few runs [first, last) of consecutive points. A structure knows which runs may hold an
 * answer; the distance test is the same code for both, so they agree to the last bit.
 * "Place" is a number in the sorted order, "point" a number of the caller's cloud.
 */
#ifndef SCATTER_SEARCH_KIND_H
#define SCATTER_SEARCH_KIND_H

#include "scatter/search.h"

/* A box, or a single place where lower = upper. */
typedef struct {
  double lower[SCT_DIM_MAX], upper[SCT_DIM_MAX];
} sct_box;

/* Cells of one side: point x is in cell (i, j, k) = floor((x - lower) per_length), number
 * c = i + count[0] (j + count[1] k), which holds the places start[c] .. start[c+1]-1. */
typedef struct {
  double lower[SCT_DIM_MAX];
  double side, per_length; /* per_length = 1 / side */
  int64_t count[SCT_DIM_MAX];
  int32_t *start;  /* [cells + 1] */
  double crowding; /* mean over the points of the number of points in the cell of the point */
} sct_cells;

/* Complete binary tree: node m has the children 2 m and 2 m + 1, the root is 1, and node j of
 * level l (m = 2^l + j) holds the places n j / 2^l .. n (j + 1) / 2^l - 1. */
typedef struct {
  int depth;   /* level of the leaves */
  double *box; /* [2^(depth+1)][2][dim] tight lower and upper corner of a node's points */
} sct_tree;

/* What is done with a run. False: enough. */
typedef bool sct_visit(void *into, int64_t first, int64_t last);

/* The methods of a structure. */
typedef struct {
  sct_search_method method;
  const char *name;
  /* Fills search->order and step. The search has dim, n, scale and box; its x is sorted afterwards.
   */
  sct_status (*build)(sct_search *search, const sct_cloud *cloud, sct_error *err);
  void (*clear)(sct_search *search);
  /* Visits, in ascending order, runs that hold all points less than radius away from a box. */
  void (*walk)(const sct_search *search, const sct_box *box, double radius, sct_visit *visit,
               void *into);
  /* The places from `place` up to this one are close together and always in one run. */
  int64_t (*bundle_end)(const sct_search *search, int64_t place);
} sct_search_kind_of;

extern const sct_search_kind_of sct_search_grid, sct_search_tree;

struct sct_search {
  const sct_search_kind_of *kind;
  int dim;
  int64_t n;
  double scale;           /* a power of two that brings the cloud into the range of squares */
  sct_box box;            /* around all points, scaled; 0 in the axes the cloud does not have */
  double *x[SCT_DIM_MAX]; /* [dim][n] sorted coordinates times scale */
  int32_t *order;         /* [n] point at a place */
  double step;            /* > 0: about the distance of neighbours, to begin a search with */
  sct_cells cells;        /* of the grid */
  sct_tree tree;          /* of the tree */
};

#endif
