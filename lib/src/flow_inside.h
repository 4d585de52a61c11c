/* flow_inside.h - what a flow holds, for the files flow_*.c that make a step of it.
 *
 * A step goes: bins (sites by cell) -> sums (rows of every particle) -> diffusion -> transfer (to
 * faces) -> pressure (projection) -> motion (increments, paths, shift) -> control (in, out, too
 * many, too few). Every loop over particles or faces gathers, and writes what is its own, so that
 * the result does not depend on threads.
 */
#ifndef SCATTER_FLOW_INSIDE_H
#define SCATTER_FLOW_INSIDE_H

#include "flow_mesh.h"
#include "solve_cholmod.h"

/* Fields that particles carry. */
enum { FLOW_U, FLOW_V, FLOW_C, FLOW_FIELDS };

enum { FLOW_NEAR_MOST = 400 }; /* sites within a support */

/* The particles, side by side; `capacity` of each. */
typedef struct {
  int64_t n, capacity;
  double *x[2];
  double *field[FLOW_FIELDS]; /* [FLOW_C] NULL without a scalar */
} flow_particles;

/* Where a site comes from, if not from a particle. */
enum { SITE_WALL = -1, SITE_WALL_NO_FLUX = -2, SITE_INFLOW = -3, SITE_MIRROR = -4 };

/* All points that sums run over - particles, wall points, points upstream of an inflow, mirror
 * images - sorted by cell: those of cell c are start[c] .. start[c+1]-1. */
typedef struct {
  int64_t n, capacity;
  double *x[2];
  double *field[FLOW_FIELDS];
  int32_t *particle; /* number of the particle, or SITE_* */
  int32_t *start;    /* [cells + 1] */
  /* before sorting */
  double *raw_x[2], *raw_field[FLOW_FIELDS];
  int32_t *raw_cell, *raw_particle;
} flow_sites;

/* A fixed point on a wall. */
typedef struct {
  double x[2], velocity[2], scalar;
  bool has_scalar;
  int axis; /* of the wall's normal */
} flow_wall_point;

/* A row of particles on their way through an inflow. */
typedef struct {
  int32_t bound;
  double travelled; /* since the last one entered (length) */
} flow_inlet;

/* What the sums of a particle give: [n] each. */
typedef struct {
  int64_t capacity;
  double *density;                  /* S_w */
  double *lopsided[2];              /* o / S_w (1 / length) */
  double *gradient[FLOW_FIELDS][2]; /* of [H16] eq. 19 */
  double *diffused[FLOW_FIELDS];    /* field + theta nu dt lap field */
  uint8_t *limited;
} flow_rows;

/* A snapshot. */
typedef struct {
  double time;
  int64_t n;
  double *x, *u, *c;
} flow_snapshot;

struct sct_flow {
  sct_flow_options options;
  double *save; /* [options.saves] copy */
  flow_mesh mesh;
  sct_cholesky *factor;
  int32_t *unknown; /* [cells] of the pressure matrix, or -1 */
  int64_t unknowns;
  double *right, *phi; /* [unknowns] */
  double *face[2];     /* [faces] projected velocity with its ghosts */
  double *change[2];   /* [faces] of the last projection, with its ghosts */
  flow_particles particles, spare;
  flow_sites sites;
  flow_rows rows;
  flow_wall_point *wall;
  int64_t walls;
  flow_inlet *inlet;
  int64_t inlets;
  uint8_t *drop;   /* [particles.capacity] to be removed */
  double *seed;    /* [cells][2] places tried for new particles */
  uint8_t *seeded; /* [cells] */
  bool controls;   /* number control is on */
  double full;     /* n0: S_w of a complete lattice neighbourhood */
  double stable;   /* stable step of ps on a lattice, times diffusivity / delta^2 */
  double speed;    /* largest of boundary and start: what "too fast" is measured by */
  /* time */
  double time, step;
  int64_t steps, inserted, removed, updates, limited;
  int64_t next_stop; /* of save times and end */
  int64_t next_sample;
  double divergence_before, divergence; /* of the last step */
  /* means */
  double averaged;  /* time */
  double *mean[2];  /* [faces] integrals over time */
  double *mean_phi; /* [unknowns] of pressure */
  double mean_q, mean_q2;
  /* results */
  sct_flow_sample *history;
  int64_t samples;
  flow_snapshot *snapshot; /* [options.saves] */
  int64_t snapshots;
  /* for views */
  double *view_x, *view_u, *view_c;
  int64_t view_capacity;
  double *wall_x, *wall_u;
};

/* ---- flow.c ---- */

/* Memory for the views of the particles there are: after every change of their number. */
SCT_NODISCARD sct_status flow_reserve_views(sct_flow *f, sct_error *err);

/* ---- flow_bins.c ---- */

/* Sorts everything that sums run over into cells, the particles themselves as well. SCT_E_MEMORY.
 */
SCT_NODISCARD sct_status flow_bins_fill(sct_flow *flow, sct_error *err);
SCT_NODISCARD sct_status flow_particles_reserve(sct_flow *flow, int64_t n, sct_error *err);
void flow_bins_clear(sct_flow *flow);

/* ---- flow_near.c, flow_rows.c ---- */

/* The sites around a place, laid out for arithmetic. */
typedef struct {
  int n;
  double x[2][FLOW_NEAR_MOST + 8];                                             /* offsets */
  double r2[FLOW_NEAR_MOST + 8], w[FLOW_NEAR_MOST + 8], f[FLOW_NEAR_MOST + 8]; /* w / r^2 */
  double q[FLOW_NEAR_MOST + 8];
  double field[FLOW_FIELDS][FLOW_NEAR_MOST + 8]; /* differences to the particle's */
  int32_t site[FLOW_NEAR_MOST + 8];
} flow_near;

/* Sites with 0 < r < support around x in cell (i, j): x, r2, site. False: too many. */
bool flow_near_gather(const sct_flow *flow, int64_t i, int64_t j, const double x[2], double support,
                      flow_near *near);
/* w of those, and their sum. */
double flow_near_weigh(const sct_flow *flow, double support, flow_near *near);

/* flow->rows of all particles for a step dt. SCT_E_UNSTABLE where a neighbourhood is too dense. */
SCT_NODISCARD sct_status flow_rows_make(sct_flow *flow, double dt, const sct_work *work,
                                        sct_error *err);

/* The ratio sum |l| / sum l that an lsmps row may have; its weights of the Laplacian in near->q.
 * False where the neighbourhood carries no fit. Proof: unit.flow.rows */
bool flow_lsmps_weights(flow_near *near, double delta);

/* ---- flow_transfer.c ---- */

/* Values at faces from values at sites: face[a] = u*, v* at inner and outflow faces, the prescribed
 * velocity elsewhere. */
SCT_NODISCARD sct_status flow_transfer(sct_flow *flow, const sct_work *work, sct_error *err);

/* All fields at a place by a linear fit over particles and walls within `reach` [2]; NaN if there
 * is nothing near. */
void flow_fit_at(const sct_flow *flow, const double x[2], const double reach[2],
                 double value[FLOW_FIELDS]);

/* ---- flow_pressure.c ---- */

SCT_NODISCARD sct_status flow_pressure_build(sct_flow *flow, sct_error *err);
/* Makes flow->face free of divergence and leaves what that changed in flow->change. */
SCT_NODISCARD sct_status flow_project(sct_flow *flow, sct_error *err);
void flow_prescribe(sct_flow *flow); /* boundary values of flow->face */

/* ---- flow_motion.c ---- */

/* Bilinear interpolation of face values at a place in cell (i, j). */
void flow_interpolate(const flow_mesh *mesh, double *const face[2], int64_t i, int64_t j,
                      const double x[2], double value[2]);
/* Increments, paths and shift of all particles; marks those that left in flow->drop. */
SCT_NODISCARD sct_status flow_move(sct_flow *flow, double dt, const sct_work *work, sct_error *err);

/* ---- flow_control.c ---- */

/* Removes what left, and lets particles in. */
SCT_NODISCARD sct_status flow_exchange(sct_flow *flow, double dt, sct_error *err);
/* Removes where particles are too many and inserts where they are too few. The bins are filled
 * before and after. */
SCT_NODISCARD sct_status flow_control(sct_flow *flow, const sct_work *work, sct_error *err);
/* Number k of draw `what` of the flow's random numbers, in [0, 1). */
double flow_random(const sct_flow *flow, uint64_t what, uint64_t k);

/* ---- flow_wall.c ---- */

SCT_NODISCARD sct_status flow_walls_build(sct_flow *flow, sct_error *err);
/* Values of no-flux wall points from the particles around, in the sites. */
void flow_walls_insulate(sct_flow *flow);
/* Mirror images of particle p in cell (i, j), at most FLOW_MIRRORS_MOST: calls add for each. */
typedef struct {
  double x[2], field[FLOW_FIELDS];
} flow_image;
enum { FLOW_IMAGES_MOST = 8 };
int flow_wall_images(const sct_flow *flow, int64_t p, int64_t i, int64_t j,
                     flow_image image[FLOW_IMAGES_MOST]);

/* ---- flow_measure.c ---- */

SCT_NODISCARD sct_status flow_measure(sct_flow *flow, const sct_work *work, sct_error *err);
void flow_average(sct_flow *flow, double dt);

#endif
