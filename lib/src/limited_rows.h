/* limited_rows.h - what `limited` keeps of a cloud: gradients and edges of every point, by blocks
 * of points, as threads make and use them. */
#ifndef SCATTER_LIMITED_ROWS_H
#define SCATTER_LIMITED_ROWS_H

#include "points.h"
#include "scatter/assemble.h"

/* Rows of the points of one block; the entries of its k-th point are start[k] .. start[k+1]-1. */
typedef struct {
  int64_t capacity;
  int64_t start[SCT_POINTS_BLOCK + 1];
  int32_t *index; /* neighbour */
  double *value;  /* [][width] */
} limited_rows;

/* Values of an edge. */
enum { EDGE_CONVECTION, EDGE_NEGATIVE, EDGE_WIDTH };

typedef struct sct_limited {
  int dim;
  int64_t n, blocks;
  double *x;               /* [n][dim] a copy of the points */
  limited_rows *gradients; /* [blocks] width dim: G_i */
  limited_rows *edges;     /* [blocks] width 2: k_ij, and a_ij where it is negative, else 0 */
} sct_limited;

/* Empty rows for the points of a cloud; *limited is NULL on failure. SCT_E_MEMORY. */
SCT_NODISCARD sct_status sct_limited_new(const sct_cloud *cloud, sct_limited **limited,
                                         sct_error *err);
void sct_limited_free(sct_limited **limited);

/* Adds the edges of point i: convection k_ij [n] (NULL: 0) and pair weights a_ij [n]. Every point
 * gets some, those of a block in order; Dirichlet points get n = 0. SCT_E_MEMORY. */
SCT_NODISCARD sct_status sct_limited_add_edges(sct_limited *limited, int64_t i, int64_t n,
                                               const int32_t *index, const double *convection,
                                               const double *pair, sct_error *err);

/* Makes and adds the gradient of point i: that of ips for mps and ps, else the scheme's own, and
 * that of the edges on points with a condition. A Dirichlet point whose neighbours carry none gets
 * n = 0. Statuses of sct_stencil_row, SCT_E_MEMORY. */
SCT_NODISCARD sct_status sct_limited_add_gradient(sct_limited *limited, const sct_stencil *stencil,
                                                  int64_t i, sct_condition condition,
                                                  sct_room *room, sct_error *err);

#endif
