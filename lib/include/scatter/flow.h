/* flow.h - incompressible flow in two dimensions on moving particles with an embedded mesh.
 *
 *   du/dt = nu lap u - grad p,   div u = 0   along the paths of the particles,
 *
 * and, if asked for, a passive scalar dc/dt = kappa lap c. Velocity lives on particles that move
 * with it, so that nothing has to approximate convection; pressure lives in the cells of a mesh
 * that stays where it is (MPPM, [H16] section 4.4). What a time step does: lib/README.md.
 *
 * Lengths, times and velocities are in any units that fit together; density is 1.
 */
#ifndef SCATTER_FLOW_H
#define SCATTER_FLOW_H

#include "scatter/stencil.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- the domain ---- */

typedef struct {
  double lower[2], upper[2];
} sct_flow_box;

/* What a stretch of boundary is. wall: no slip, moves with its velocity within its plane. inflow:
 * fluid enters with a given velocity. outflow: pressure 0. */
#define SCT_FLOW_SIDE_LIST(X)  \
  X(SCT_FLOW_WALL, "wall")     \
  X(SCT_FLOW_INFLOW, "inflow") \
  X(SCT_FLOW_OUTFLOW, "outflow")
#define SCT_FLOW_ENUM(symbol, name) symbol,
typedef enum { SCT_FLOW_SIDE_LIST(SCT_FLOW_ENUM) SCT_FLOW_SIDE_COUNT } sct_flow_kind;

/* Values [n][components] at positions x [n][2]; a status other than SCT_OK ends the call that
 * asked. Every value must be finite. */
typedef sct_status sct_flow_field(void *context, int64_t n, const double *x, double *value,
                                  sct_error *err);

/* A stretch of boundary between two points of a line of the mesh. Boundary that belongs to no
 * stretch is wall at rest, and has no flux of the scalar; of several stretches the last counts. */
typedef struct {
  sct_flow_kind kind;
  double from[2], to[2];   /* its ends: they differ in one coordinate */
  double velocity[2];      /* of wall or inflow, unless there is a profile */
  sct_flow_field *profile; /* velocity [n][2] on it; NULL: `velocity` */
  void *context;           /* of profile; not needed after the build */
  bool has_scalar;         /* the scalar has a value there; else no flux (wall), 0 (inflow) */
  double scalar;
} sct_flow_side;

/* Rectangles of fluid without solid blocks on a mesh of rectangular cells. The bounds of all boxes
 * and the ends of all sides must be lines of the mesh (to 1e-9 of its extent). Blocks must be two
 * particle spacings thick or more: particles on both sides of a thinner one would see each other.
 */
typedef struct {
  int64_t cells[2];
  const double *edge[2]; /* [cells + 1] lines of the mesh in x and in y, 1e-6 of the extent apart */
  const sct_flow_box *fluid;
  int64_t fluids; /* 0: all of the mesh */
  const sct_flow_box *solid;
  int64_t solids;
  const sct_flow_side *side;
  int64_t sides;
} sct_flow_domain;

/* ---- how it is computed ---- */

/* How the sums of a particle end at a wall: fixed points on the wall that carry its velocity, or
 * images of the particles behind it that carry 2 u_wall - u. */
#define SCT_FLOW_WALLS_LIST(X)      \
  X(SCT_FLOW_WALL_POINTS, "points") \
  X(SCT_FLOW_WALL_MIRROR, "mirror")
typedef enum { SCT_FLOW_WALLS_LIST(SCT_FLOW_ENUM) SCT_FLOW_WALLS_COUNT } sct_flow_walls;
#undef SCT_FLOW_ENUM

/* Name of a value, NULL out of range. */
const char *sct_flow_kind_name(sct_flow_kind kind);
const char *sct_flow_walls_name(sct_flow_walls walls);

typedef struct {
  double viscosity; /* nu > 0 (length^2 / time) */
  sct_operator op;  /* ps, ips, ipsn, or lsmps of degree 2; local density, no upwinding; radius up
                       to 3 for the mesh's margin */
  sct_flow_walls walls;
  double courant;          /* steps: at most courant min(delta, dx) / |u| of any cell, in (0, 1] */
  double diffusion_number; /* and diffusion_number times the stable step of ps on a lattice */
  double shift;            /* c of the shift, in [0, 1]; useful from 0.1 to 0.5 */
  double jitter;           /* of the particles at the start, in cell widths, [0, 1) */
  uint64_t seed;           /* of jitter and of places where particles are inserted */
  double end;              /* (time) */
  double average_from;     /* (time) means are taken from here to the end */
  int64_t samples;         /* rows of the history, evenly over time */
  const double *save;      /* [saves] ascending times in (0, end] of snapshots */
  int64_t saves;
  int64_t max_particles;   /* more: SCT_E_LIMIT */
  bool has_scalar;         /* a scalar rides along */
  double diffusivity;      /* kappa >= 0 of it (length^2 / time) */
  sct_flow_field *initial; /* its values [n] at the start; NULL: 0 */
  void *context;           /* of initial */
} sct_flow_options;

/* The prototype's parameters: courant 0.25, diffusion_number 0.8, shift 0.25, points on walls, 200
 * samples, means over the last quarter, one particle per cell, max_particles 2^27. */
sct_flow_options sct_flow_default(sct_scheme scheme, double viscosity, double end);

/* ---- a flow ---- */

typedef struct sct_flow sct_flow; /* opaque; owns all it needs */

/* Lays out mesh, walls and one particle per cell, factors the pressure matrix, and starts from the
 * potential flow that the inflow drives (rest, without). *flow is NULL on failure.
 * SCT_E_ARGUMENT (lines that do not ascend, boxes or sides off the lines, sides off the boundary,
 * walls that are penetrated, an inflow that has no way out, thin blocks, no fluid, options out of
 * range); SCT_E_NOT_FINITE (profile, initial values); SCT_E_LIMIT, SCT_E_MEMORY.
 * Cost: that of a sparse Cholesky factorisation, O(cells^(3/2)).
 * Proof: unit.flow, verify.flow, fault.flow */
SCT_NODISCARD sct_status sct_flow_build(const sct_flow_domain *domain,
                                        const sct_flow_options *options, sct_flow **flow,
                                        sct_error *err);
void sct_flow_free(sct_flow **flow);

/* Makes up to `steps` time steps, fewer where the end is reached; what comes out does not depend on
 * how many calls make the steps, nor on the threads of `work`. Tells the fraction of the whole time
 * as phase "march" after every step. The cloud must not be more than 400 neighbours dense, nor may
 * velocities exceed 1e6 times those of the boundary and start (SCT_E_UNSTABLE); SCT_E_LIMIT,
 * SCT_E_MEMORY, SCT_E_CANCELLED. After a failure only _free is allowed, after SCT_E_CANCELLED all.
 * Cost O(particles) and one triangular solve per step. Proof: verify.flow, fault.flow */
SCT_NODISCARD sct_status sct_flow_advance(sct_flow *flow, int64_t steps, const sct_work *work,
                                          sct_error *err);
bool sct_flow_is_done(const sct_flow *flow);

/* All that changes in a flow, as bytes: *bytes (free() it) and *size. sct_flow_load puts it into a
 * flow built from the same domain and options (SCT_E_ARGUMENT for bytes of another one, or
 * damaged), which then goes on bit for bit as the saved one would have. SCT_E_MEMORY.
 * Proof: unit.flow.state */
SCT_NODISCARD sct_status sct_flow_save(const sct_flow *flow, void **bytes, size_t *size,
                                       sct_error *err);
SCT_NODISCARD sct_status sct_flow_load(sct_flow *flow, const void *bytes, size_t size,
                                       sct_error *err);

/* ---- what it has come to ----
 * Views: valid until the next advance, load or free. */

typedef struct {
  double time;
  int64_t n;
  const double *x; /* [n][2] positions */
  const double *u; /* [n][2] velocities */
  const double *c; /* [n] scalar, or NULL */
} sct_flow_cloud;

sct_flow_cloud sct_flow_particles(const sct_flow *flow);           /* now */
int64_t sct_flow_snapshots(const sct_flow *flow);                  /* saved so far */
sct_flow_cloud sct_flow_snapshot(const sct_flow *flow, int64_t k); /* the k-th of them */

/* Fixed points on the walls with their velocities (none where walls are mirrors): what completes
 * the cloud for `diagnose` and `apply`. */
sct_flow_cloud sct_flow_wall_points(const sct_flow *flow);

/* Fields on the mesh, means from average_from on (before that, and with `now`: of the last step).
 * Memory of the caller, each may be NULL: pressure [ny][nx] in cells (NaN in solid), stream [ny +
 * 1][nx + 1] at nodes (0 on the lower end of each line, psi_y = u), u [ny][nx + 1], v [ny + 1][nx]
 * on faces. */
void sct_flow_mesh(const sct_flow *flow, bool now, double *pressure, double *stream, double *u,
                   double *v);

/* Velocity component `along` (0: u, 1: v) of those fields on the line across the mesh where the
 * other coordinate is `at`: u over y at x = at, or v over x at y = at. One value for every cell
 * centre that is fluid and the two ends of the line: s, value [n] out for n =
 * sct_flow_section_most; returns how many. */
int64_t sct_flow_section_most(const sct_flow *flow, int along);
int64_t sct_flow_section(const sct_flow *flow, bool now, int along, double at, double *s,
                         double *value);

/* Primary vortex: least value of the stream function, refined by parabolas, and where. */
typedef struct {
  double x, y, circulation; /* circulation = -psi */
} sct_flow_vortex;
sct_flow_vortex sct_flow_find_vortex(const sct_flow *flow, bool now);

/* Where the shear at the wall below changes from backward to forward, along the row of cells above
 * the horizontal line y, to the right of x: zero of the one-sided derivative through the two first
 * rows. NaN if there is none. */
double sct_flow_reattachment(const sct_flow *flow, bool now, double x, double y);

/* A row of the history. */
typedef struct {
  double t, circulation;
  double particles;
  double divergence;         /* max |div u| after projection (1 / time) */
  double divergence_before;  /* root mean square of it before */
  double cell_reynolds;      /* rms |u_N| delta of ps, [H16] eq. 13: (4 / S_w) |o| delta */
  double diffusivity_mean;   /* half the trace of the ips tensor, mean over particles */
  double diffusivity_rms;    /* root mean square of its xy entry */
  double empty, crowded;     /* cells without and with more than 3 particles (fraction) */
  double nearest, nearest_1; /* distance to the nearest neighbour / delta: median, 1st percentile */
  double limited;            /* updates of diffusion that were limited so far (fraction) */
  double speed;              /* largest of the particles */
  double scalar;             /* mean */
} sct_flow_sample;
int64_t sct_flow_history(const sct_flow *flow, const sct_flow_sample **sample);

typedef struct {
  double time, step; /* reached; last step */
  int64_t steps, particles, cells, inserted, removed;
  double circulation_deviation; /* standard deviation over the means' time */
} sct_flow_report;
sct_flow_report sct_flow_reports(const sct_flow *flow);

#ifdef __cplusplus
}
#endif
#endif
