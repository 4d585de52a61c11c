/* flow_motion.c - particles take the change of the faces, go along, and are kept apart. */
#include <math.h>

#include "flow_inside.h"
#include "parallel.h"

/* Particles keep this distance from walls, and are shifted no farther than that, in spacings. */
static const double WALL_GAP = 0.05, SHIFT_MOST = 0.1;

void flow_interpolate(const flow_mesh *m, double *const face[2], int64_t i, int64_t j,
                      const double x[2], double value[2]) {
  const int64_t cell[2] = {i, j};
  for (int a = 0; a < 2; a++) { /* linear between lines along a, between centres across */
    const int b = 1 - a;
    const flow_axis *along = &m->axis[a], *across = &m->axis[b];
    const int64_t stride[2] = {1, m->axis[0].n + (a == 0)};
    int64_t low = x[b] < across->centre[cell[b]] ? cell[b] - 1 : cell[b];
    low = low < 0 ? 0 : low < across->n - 1 ? low : across->n - 2; /* whatever x is */
    const double s = (x[a] - along->edge[cell[a]]) / along->width[cell[a]];
    const double t = (x[b] - across->centre[low]) / (across->centre[low + 1] - across->centre[low]);
    const double *p = face[a] + cell[a] * stride[a] + low * stride[b];
    value[a] = (1 - t) * ((1 - s) * p[0] + s * p[stride[a]]) +
               t * ((1 - s) * p[stride[b]] + s * p[stride[a] + stride[b]]);
  }
}

/* The fluid cell that x is in; that of the particle before where x is in none. */
static void locate(const flow_mesh *m, const double x[2], int64_t cell[2]) {
  const int64_t i = flow_axis_find(&m->axis[0], x[0]), j = flow_axis_find(&m->axis[1], x[1]);
  if (!m->fluid[flow_cell(m, i, j)]) return;
  cell[0] = i;
  cell[1] = j;
}

/* Kind of the face of a fluid cell on its lower (side 0) or upper side along a. */
static flow_face kind_at(const flow_mesh *m, const int64_t cell[2], int a, int side) {
  return (flow_face)
      m->kind[a][flow_face_below(m, a, cell[0] + (a == 0 && side), cell[1] + (a == 1 && side))];
}

/* Keeps x within the cell where it has a wall or inflow, however thin it is; true if it left by an
 * outflow. */
static bool confine(const flow_mesh *m, const int64_t cell[2], double x[2]) {
  const double delta = sqrt(m->axis[0].width[cell[0]] * m->axis[1].width[cell[1]]);
  bool left = false;
  for (int a = 0; a < 2; a++) {
    const double low = m->axis[a].edge[cell[a]], high = m->axis[a].edge[cell[a] + 1];
    const flow_face below = kind_at(m, cell, a, 0), above = kind_at(m, cell, a, 1);
    const double most = (high - low) / 4;
    const double gap_below = fmin((below == FACE_WALL ? WALL_GAP : 1e-6) * delta, most);
    const double gap_above = fmin((above == FACE_WALL ? WALL_GAP : 1e-6) * delta, most);
    left |= (below == FACE_OUTFLOW && x[a] <= low) || (above == FACE_OUTFLOW && x[a] >= high);
    if (below == FACE_WALL || below == FACE_INFLOW) x[a] = fmax(x[a], low + gap_below);
    if (above == FACE_WALL || above == FACE_INFLOW) x[a] = fmin(x[a], high - gap_above);
  }
  return left;
}

/* Brings a particle that was in `cell` to x, round walls; true if it left. */
static bool settle(const flow_mesh *m, const int64_t cell[2], double x[2]) {
  int64_t now[2] = {flow_axis_find(&m->axis[0], x[0]), flow_axis_find(&m->axis[1], x[1])};
  if (!m->fluid[flow_cell(m, now[0], now[1])]) {
    if (confine(m, cell, x)) return true; /* past a side of its own cell */
    now[0] = flow_axis_find(&m->axis[0], x[0]);
    now[1] = flow_axis_find(&m->axis[1], x[1]);
  }
  if (!m->fluid[flow_cell(m, now[0], now[1])]) { /* across a corner: back into its own cell */
    for (int a = 0; a < 2; a++) {
      const double low = m->axis[a].edge[cell[a]], high = m->axis[a].edge[cell[a] + 1];
      const double gap = WALL_GAP * (high - low);
      x[a] = fmin(fmax(x[a], low + gap), high - gap);
      now[a] = cell[a];
    }
  }
  return confine(m, now, x);
}

/* dr = -c delta^2 (o / S_w - (1/2) grad ln n_t), no longer than a tenth of delta. */
static void shift_of(const sct_flow *f, int64_t p, const int64_t cell[2], const double x[2],
                     double dr[2]) {
  double thin[2];
  const double delta = flow_spacing(&f->mesh, cell[0], cell[1], x, thin);
  for (int a = 0; a < 2; a++) {
    dr[a] = -f->options.shift * delta * delta * (f->rows.lopsided[a][p] - thin[a] / 2);
  }
  const double length = hypot(dr[0], dr[1]), most = SHIFT_MOST * delta;
  for (int a = 0; a < 2 && length > most; a++) dr[a] *= most / length;
}

typedef struct {
  sct_flow *flow;
  double dt;
} job;

static void move_particle(sct_flow *f, double dt, int64_t p) {
  const flow_mesh *m = &f->mesh;
  flow_particles *all = &f->particles;
  const double old[2] = {all->x[0][p], all->x[1][p]};
  int64_t cell[2] = {flow_axis_find(&m->axis[0], old[0]), flow_axis_find(&m->axis[1], old[1])};
  const int64_t home[2] = {cell[0], cell[1]};
  double change[2], v[2], x[2], dr[2];
  flow_interpolate(m, f->change, cell[0], cell[1], old, change);
  flow_interpolate(m, f->face, cell[0], cell[1], old, v);
  for (int a = 0; a < 2; a++) x[a] = old[a] + dt / 2 * v[a];
  locate(m, x, cell);
  flow_interpolate(m, f->face, cell[0], cell[1], x, v);
  shift_of(f, p, home, old, dr);
  for (int a = 0; a < 2; a++) x[a] = old[a] + dt * v[a] + dr[a];
  f->drop[p] = settle(m, home, x);
  for (int a = 0; a < 2; a++) { /* off the path by the shift, and by walls in the way */
    dr[a] = x[a] - (old[a] + dt * v[a]);
    all->x[a][p] = x[a];
  }
  for (int q = 0; q < (f->options.has_scalar ? FLOW_FIELDS : FLOW_C); q++) {
    double value = f->rows.diffused[q][p] + (q == FLOW_C ? 0 : change[q]);
    for (int a = 0; a < 2; a++) value += f->rows.gradient[q][a][p] * dr[a];
    all->field[q][p] = value;
  }
}

static bool move_some(void *context, int64_t first, int64_t last, int t) {
  const job *to = context;
  (void)t;
  for (int64_t p = first; p < last; p++) move_particle(to->flow, to->dt, p);
  return true;
}

sct_status flow_move(sct_flow *f, double dt, const sct_work *work, sct_error *err) {
  const sct_work quiet = {.threads = sct_work_threads(work)};
  job to = {f, dt};
  bool complete;
  return sct_in_pieces(f->particles.n, &quiet, "move", move_some, &to, &complete, err);
}
