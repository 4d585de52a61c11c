/* flow_control.c - how many particles there are: those that enter and leave, and where they became
 * too many or too few. */
#include <math.h>
#include <string.h>

#include "alloc.h"
#include "flow_inside.h"
#include "parallel.h"

/* Remove a local maximum of the number density above TOO_MANY n0, insert below TOO_FEW n0; a new
 * one takes its velocity from REACH spacings around. */
static const double TOO_MANY = 1.6, TOO_FEW = 1.0, REACH = 2.2;

/* Where cells are longer than high, or few, that leaves too many without a particle (a graded step:
 * 17 to 21 %). Into those goes one also at a higher density, the more there are of them, unless
 * there are PLENTY times as many particles as cells. It cannot help cells at a wall that are
 * flatter than the spacing, which next to wall points are rightly empty. */
static const double EMPTY_MOST = 0.12, EMPTY_GAIN = 12, EMPTY_DENSITY = 1.45, PLENTY = 1.05;

double flow_random(const sct_flow *f, uint64_t what, uint64_t k) {
  uint64_t z = f->options.seed * 0x9e3779b97f4a7c15u + what;
  for (int round = 0; round < 2; round++) { /* SplitMix64's mixing, once per number */
    z += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    z ^= z >> 31;
    if (round == 0) z += k;
  }
  return (double)(z >> 11) * 0x1p-53;
}

/* ---- in and out ---- */

static int fields_of(const sct_flow *f) {
  return f->options.has_scalar ? FLOW_FIELDS : FLOW_C;
}

/* Closes the ranks over particles that are to be dropped. */
static void close_ranks(sct_flow *f) {
  flow_particles *p = &f->particles;
  int64_t n = 0;
  for (int64_t k = 0; k < p->n; k++) {
    if (f->drop[k]) continue;
    for (int a = 0; a < 2; a++) p->x[a][n] = p->x[a][k];
    for (int q = 0; q < fields_of(f); q++) p->field[q][n] = p->field[q][k];
    n++;
  }
  f->removed += p->n - n;
  p->n = n;
}

static sct_status insert(sct_flow *f, const double x[2], const double field[FLOW_FIELDS],
                         sct_error *err) {
  flow_particles *p = &f->particles;
  const sct_status status = flow_particles_reserve(f, p->n + 1, err);
  if (status != SCT_OK) return status;
  for (int a = 0; a < 2; a++) p->x[a][p->n] = x[a];
  for (int q = 0; q < fields_of(f); q++) p->field[q][p->n] = field[q];
  f->drop[p->n++] = 0;
  f->inserted++;
  return SCT_OK;
}

static sct_status enter(sct_flow *f, flow_inlet *in, double dt, sct_error *err) {
  const flow_bound *b = &f->mesh.bound[in->bound];
  const int64_t own = b->axis == 0 ? b->i : b->j, along = b->axis == 0 ? b->j : b->i;
  const flow_axis *normal = &f->mesh.axis[b->axis], *across = &f->mesh.axis[1 - b->axis];
  const double depth = normal->width[own], line = normal->edge[own + (b->inward < 0)];
  const double field[FLOW_FIELDS] = {b->velocity[0], b->velocity[1], b->scalar};
  in->travelled += fmax(0, b->inward * b->velocity[b->axis]) * dt;
  if (in->travelled < depth) return SCT_OK;
  in->travelled -= depth;
  double x[2];
  x[b->axis] = line + b->inward * fmax(in->travelled, 1e-6 * depth);
  x[1 - b->axis] = across->centre[along];
  return insert(f, x, field, err);
}

sct_status flow_exchange(sct_flow *f, double dt, sct_error *err) {
  sct_status status = SCT_OK;
  close_ranks(f);
  for (int64_t k = 0; k < f->inlets && status == SCT_OK; k++) {
    status = enter(f, &f->inlet[k], dt, err);
  }
  return status;
}

/* ---- too many ---- */

static double density_at(const sct_flow *f, int64_t i, int64_t j, const double x[2],
                         flow_near *near) {
  const double delta = flow_spacing(&f->mesh, i, j, x, NULL);
  const double support = f->options.op.radius * delta;
  if (!flow_near_gather(f, i, j, x, support, near)) return INFINITY;
  return flow_near_weigh(f, support, near);
}

static bool find_density(void *context, int64_t first, int64_t last, int t) {
  sct_flow *f = context;
  flow_near near;
  (void)t;
  for (int64_t p = first; p < last; p++) {
    const double x[2] = {f->particles.x[0][p], f->particles.x[1][p]};
    const int64_t i = flow_axis_find(&f->mesh.axis[0], x[0]);
    const int64_t j = flow_axis_find(&f->mesh.axis[1], x[1]);
    f->rows.density[p] = density_at(f, i, j, x, &near);
  }
  return true;
}

/* Is p too many, and more so than all within delta? Of equals the first. */
static bool is_too_many(const sct_flow *f, int64_t p, flow_near *near) {
  const double own = f->rows.density[p];
  const double x[2] = {f->particles.x[0][p], f->particles.x[1][p]};
  const int64_t i = flow_axis_find(&f->mesh.axis[0], x[0]);
  const int64_t j = flow_axis_find(&f->mesh.axis[1], x[1]);
  if (!(own > TOO_MANY * f->full)) return false;
  if (!flow_near_gather(f, i, j, x, flow_spacing(&f->mesh, i, j, x, NULL), near)) return true;
  for (int k = 0; k < near->n; k++) {
    const int32_t other = f->sites.particle[near->site[k]];
    if (other < 0) continue;
    const double density = f->rows.density[other];
    if (density > own || (density == own && other < p)) return false;
  }
  return true;
}

static bool find_too_many(void *context, int64_t first, int64_t last, int t) {
  sct_flow *f = context;
  flow_near near;
  (void)t;
  for (int64_t p = first; p < last; p++) f->drop[p] = is_too_many(f, p, &near);
  return true;
}

/* ---- too few ---- */

/* A random place of a cell, a tenth of its width away from its sides. */
static void random_place(const sct_flow *f, int64_t i, int64_t j, double x[2]) {
  const int64_t cell[2] = {i, j};
  for (int a = 0; a < 2; a++) {
    const uint64_t k = (uint64_t)(2 * flow_cell(&f->mesh, i, j) + a);
    const double chi = flow_random(f, (uint64_t)f->steps + 1, k);
    x[a] = f->mesh.axis[a].edge[cell[a]] + f->mesh.axis[a].width[cell[a]] * (0.1 + 0.8 * chi);
  }
}

static bool is_empty(const sct_flow *f, int64_t c) {
  for (int64_t k = f->sites.start[c]; k < f->sites.start[c + 1]; k++) {
    if (f->sites.particle[k] >= 0) return false;
  }
  return true;
}

/* Number density up to which an empty cell gets a particle. */
static double density_for_empty(const sct_flow *f) {
  int64_t empty = 0;
  if ((double)f->particles.n > PLENTY * (double)f->mesh.fluids) return TOO_FEW * f->full;
  for (int64_t c = 0; c < f->mesh.cells; c++) empty += f->mesh.fluid[c] && is_empty(f, c);
  const double excess = (double)empty / (double)f->mesh.fluids - EMPTY_MOST;
  return fmin(TOO_FEW + EMPTY_GAIN * fmax(0, excess), EMPTY_DENSITY) * f->full;
}

typedef struct {
  sct_flow *flow;
  double for_empty;
} gaps;

/* Tries a place in each of the cells first .. last-1. */
static bool find_too_few(void *context, int64_t first, int64_t last, int t) {
  const gaps *to = context;
  sct_flow *f = to->flow;
  const int64_t nx = f->mesh.axis[0].n;
  flow_near near;
  (void)t;
  for (int64_t c = first; c < last; c++) {
    f->seeded[c] = 0;
    if (!f->mesh.fluid[c]) continue;
    random_place(f, c % nx, c / nx, f->seed + 2 * c);
    const double least = is_empty(f, c) ? to->for_empty : TOO_FEW * f->full;
    f->seeded[c] = density_at(f, c % nx, c / nx, f->seed + 2 * c, &near) < least;
  }
  return true;
}

/* Places that were found at the same time may be too close to each other: those in the eight cells
 * around, which have lower numbers, go first. */
static bool is_free(const sct_flow *f, int64_t c) {
  const int64_t nx = f->mesh.axis[0].n, before[4] = {c - 1, c - nx - 1, c - nx, c - nx + 1};
  const double *x = f->seed + 2 * c;
  const double delta = flow_spacing(&f->mesh, c % nx, c / nx, x, NULL);
  for (int k = 0; k < 4; k++) {
    const double *y = f->seed + 2 * before[k];
    if (f->seeded[before[k]] && hypot(x[0] - y[0], x[1] - y[1]) < 0.7 * delta) return false;
  }
  return true;
}

static sct_status fill_gaps(sct_flow *f, sct_error *err) {
  const int64_t nx = f->mesh.axis[0].n;
  sct_status status = SCT_OK;
  for (int64_t c = 0; c < f->mesh.cells && status == SCT_OK; c++) {
    double field[FLOW_FIELDS];
    if (!f->seeded[c]) continue;
    f->seeded[c] = is_free(f, c);
    if (!f->seeded[c]) continue;
    const double *x = f->seed + 2 * c;
    const double reach = REACH * flow_spacing(&f->mesh, c % nx, c / nx, x, NULL);
    flow_fit_at(f, x, (double[2]){reach, reach}, field);
    if (!isfinite(field[FLOW_U])) continue; /* nothing far around: particles will come */
    status = insert(f, x, field, err);
  }
  return status;
}

sct_status flow_control(sct_flow *f, const sct_work *work, sct_error *err) {
  const sct_work quiet = {.threads = sct_work_threads(work)};
  const int64_t n = f->particles.n, inserted = f->inserted;
  bool complete;
  sct_status status = sct_in_pieces(n, &quiet, "control", find_density, f, &complete, err);
  if (status == SCT_OK) {
    status = sct_in_pieces(n, &quiet, "control", find_too_many, f, &complete, err);
  }
  if (status == SCT_OK) {
    gaps to = {f, density_for_empty(f)};
    status = sct_in_pieces(f->mesh.cells, &quiet, "control", find_too_few, &to, &complete, err);
  }
  /* new ones are fitted to the bins as they are, and stand behind the others until these close up
   */
  if (status == SCT_OK) status = fill_gaps(f, err);
  if (status != SCT_OK) return status;
  close_ranks(f);
  return f->particles.n == n && f->inserted == inserted ? SCT_OK : flow_bins_fill(f, err);
}
