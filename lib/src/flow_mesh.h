/* flow_mesh.h - the embedded mesh: its lines, which cells are fluid, what each face is.
 *
 * The mesh has FLOW_PAD cells more on every side, so that nothing near the boundary is a special
 * case. All numbers of cells and faces below count them: cell (i, j) is j nx + i; x-face (i, j),
 * left of that cell, is j (nx + 1) + i; y-face (i, j), below it, is j nx + i.
 */
#ifndef SCATTER_FLOW_MESH_H
#define SCATTER_FLOW_MESH_H

#include "scatter/flow.h"

enum { FLOW_PAD = 3 };

/* What is between two cells. */
typedef enum { FACE_NONE, FACE_INNER, FACE_WALL, FACE_INFLOW, FACE_OUTFLOW } flow_face;

/* The lines of one direction. */
typedef struct {
  int64_t n;      /* cells, margin included */
  double *edge;   /* [n + 1] */
  double *centre; /* [n] */
  double *width;  /* [n] */
  double per_bucket;
  int64_t buckets;
  int32_t *bucket; /* [buckets] cell that the lower end of a bucket lies in */
} flow_axis;

/* A face of the boundary. */
typedef struct {
  int axis; /* of its normal */
  int64_t face, cell, side;
  int32_t i, j; /* of the fluid cell beside it */
  int inward;   /* +1 if that is above the face, else -1 */
  flow_face kind;
  double mean;        /* mean normal velocity */
  double velocity[2]; /* at the centre of the face */
  bool has_scalar;
  double scalar;
} flow_bound;

/* A value beyond a wall: face[to] = sign face[from] + offset. */
typedef struct {
  int32_t to, from;
  double sign, offset;
} flow_ghost;

typedef struct {
  flow_axis axis[2];
  bool is_uniform; /* all cells alike */
  double spacing;  /* delta of the smallest cell */
  int64_t cells, fluids;
  int64_t faces[2];
  uint8_t *fluid;       /* [cells] */
  uint8_t *kind[2];     /* [faces] flow_face */
  int32_t *bound_of[2]; /* [faces] number of the bound there, or -1 */
  flow_bound *bound;    /* [bounds] */
  int64_t bounds;
  flow_ghost *ghost[2]; /* tangential no-slip, for motion */
  flow_ghost *copy[2];  /* normal: increments on prescribed faces */
  int64_t ghosts[2], copies[2];
} flow_mesh;

/* The lines and their margin, with cells and faces that are nothing yet: those are made of a domain
 * by flow_domain_lay. The status: sct_flow_build. */
SCT_NODISCARD sct_status flow_mesh_build(const sct_flow_domain *domain, flow_mesh *mesh,
                                         sct_error *err);
void flow_mesh_clear(flow_mesh *mesh);

static inline int64_t flow_cell(const flow_mesh *m, int64_t i, int64_t j) {
  return j * m->axis[0].n + i;
}
/* Face of direction a on the lower side of cell (i, j). */
static inline int64_t flow_face_below(const flow_mesh *m, int a, int64_t i, int64_t j) {
  return j * (m->axis[0].n + (a == 0)) + i;
}

/* Cell of a place along an axis, kept within the mesh and its margin. */
static inline int64_t flow_axis_find(const flow_axis *a, double x) {
  double b = (x - a->edge[0]) * a->per_bucket;
  b = b > 0 ? b : 0; /* of a NaN too */
  const double last = (double)(a->buckets - 1);
  int64_t i = a->bucket[(int64_t)(b < last ? b : last)];
  while (i + 1 < a->n && x >= a->edge[i + 1]) i++;
  while (i > 0 && x < a->edge[i]) i--;
  return i;
}

/* Width of cells at a place in cell i, interpolated between centres, and its slope. */
static inline double flow_axis_width(const flow_axis *a, int64_t i, double x, double *slope) {
  const int64_t k = x < a->centre[i] ? (i > 0 ? i - 1 : 0) : (i + 1 < a->n ? i : i - 1);
  const double rate = (a->width[k + 1] - a->width[k]) / (a->centre[k + 1] - a->centre[k]);
  *slope = rate;
  return a->width[k] + rate * (x - a->centre[k]);
}

/* delta at a place in cell (i, j), and, where `thin` is not NULL, grad ln of the target density. */
double flow_spacing(const flow_mesh *mesh, int64_t i, int64_t j, const double x[2], double thin[2]);

#endif
