/* flow_wall.c - what stands at a wall: fixed points, or images of the particles before it. */
#include <math.h>

#include "alloc.h"
#include "flow_inside.h"

/* ---- points ---- */

enum { WALL_POINTS_MOST = 1 << 22 }; /* a flow of a million particles has some thousands */

/* The wall face `step` faces farther along the same straight wall, or NULL. */
static const flow_bound *along(const flow_mesh *m, const flow_bound *b, int step) {
  const int64_t stride = b->axis == 0 ? m->axis[0].n + 1 : 1;
  const int32_t k = m->bound_of[b->axis][b->face + step * stride];
  if (k < 0 || m->bound[k].inward != b->inward || m->bound[k].kind != FACE_WALL) return NULL;
  return &m->bound[k];
}

/* Length of a face in spacings of the cell beside it. */
static double spacings(const flow_mesh *m, const flow_bound *b) {
  const double w[2] = {m->axis[0].width[b->i], m->axis[1].width[b->j]};
  return w[1 - b->axis] / (sqrt(w[0]) * sqrt(w[1]));
}

static flow_wall_point point_on(const flow_mesh *m, const flow_bound *b, double part) {
  const int c = 1 - b->axis;
  const int64_t k = c == 0 ? b->i : b->j, own = c == 0 ? b->j : b->i;
  flow_wall_point p = {.velocity = {b->velocity[0], b->velocity[1]},
                       .scalar = b->scalar,
                       .has_scalar = b->has_scalar,
                       .axis = b->axis};
  p.x[b->axis] = m->axis[b->axis].edge[own + (b->inward < 0)];
  p.x[c] = m->axis[c].edge[k] + part * m->axis[c].width[k];
  return p;
}

/* Points of the straight wall that begins with face b, a spacing apart, half of one from its ends;
 * returns how many. */
static int64_t lay_wall(const flow_mesh *m, const flow_bound *b, flow_wall_point *out) {
  double length = 0, before = 0;
  for (const flow_bound *p = b; p != NULL; p = along(m, p, 1)) length += spacings(m, p);
  const int64_t n = (int64_t)fmax(1, fmin(round(length), WALL_POINTS_MOST + 1));
  for (int64_t k = 0; k < n && out != NULL; k++) {
    const double at = ((double)k + 0.5) * length / (double)n;
    while (at > before + spacings(m, b) && along(m, b, 1) != NULL) {
      before += spacings(m, b);
      b = along(m, b, 1);
    }
    out[k] = point_on(m, b, (at - before) / spacings(m, b));
  }
  return n;
}

static int64_t lay_walls(const flow_mesh *m, flow_wall_point *out) {
  int64_t n = 0;
  for (int64_t k = 0; k < m->bounds; k++) {
    const flow_bound *b = &m->bound[k];
    if (b->kind != FACE_WALL || along(m, b, -1) != NULL) continue;
    n += lay_wall(m, b, out != NULL ? out + n : NULL);
  }
  return n;
}

sct_status flow_walls_build(sct_flow *f, sct_error *err) {
  const flow_mesh *m = &f->mesh;
  f->walls = lay_walls(m, NULL);
  if (f->walls > WALL_POINTS_MOST) {
    return sct_fail(err, SCT_E_ARGUMENT, -1,
                    "walls have more than %d points, needs cells that are less thin",
                    WALL_POINTS_MOST);
  }
  for (int64_t k = 0; k < m->bounds; k++) f->inlets += m->bound[k].kind == FACE_INFLOW;
  sct_status status = sct_alloc(&f->wall, f->walls, sizeof *f->wall, err);
  if (status == SCT_OK) status = sct_alloc(&f->inlet, f->inlets, sizeof *f->inlet, err);
  if (status == SCT_OK) status = sct_alloc(&f->wall_x, 2 * f->walls, sizeof *f->wall_x, err);
  if (status == SCT_OK) status = sct_alloc(&f->wall_u, 2 * f->walls, sizeof *f->wall_u, err);
  if (status != SCT_OK) return status;
  lay_walls(m, f->wall);
  for (int64_t k = 0; k < 2 * f->walls; k++) {
    f->wall_x[k] = f->wall[k / 2].x[k % 2];
    f->wall_u[k] = f->wall[k / 2].velocity[k % 2];
  }
  int64_t n = 0;
  for (int64_t k = 0; k < m->bounds; k++) {
    const flow_bound *b = &m->bound[k];
    if (b->kind != FACE_INFLOW) continue;
    const double depth = m->axis[b->axis].width[b->axis == 0 ? b->i : b->j];
    f->inlet[n++] = (flow_inlet){(int32_t)k, depth / 2}; /* the first column is half a cell in */
  }
  return SCT_OK;
}

/* ---- no flux ---- */

/* Value at a wall point of the scalar from a fit with 1, t and n^2 along and across the wall, whose
 * derivative across is zero, kept near the values around, without which it feeds on itself; the
 * mean where there are too few particles. */
static double insulated(const sct_flow *f, const double x[2], int normal, flow_near *near) {
  const flow_mesh *m = &f->mesh;
  const int64_t i = flow_axis_find(&m->axis[0], x[0]), j = flow_axis_find(&m->axis[1], x[1]);
  const double support = 2 * flow_spacing(m, i, j, x, NULL);
  double a[6] = {0}, r[3] = {0}, least = INFINITY, most = -INFINITY;
  if (!flow_near_gather(f, i, j, x, support, near)) return 0;
  for (int k = 0; k < near->n; k++) {
    if (f->sites.particle[near->site[k]] < 0) continue;
    const double q = sqrt(near->r2[k]) / support, w = (1 - q) * (1 - q);
    const double t = near->x[1 - normal][k] / support, d = near->x[normal][k] / support;
    const double c = f->sites.field[FLOW_C][near->site[k]], p[3] = {1, t, d * d};
    least = fmin(least, c);
    most = fmax(most, c);
    for (int b = 0, e = 0; b < 3; b++) {
      for (int g = 0; g <= b; g++) a[e++] += w * p[b] * p[g];
      r[b] += w * p[b] * c;
    }
  }
  /* a: 11, t1, tt, d1, dt, dd */
  const double c0 = a[2] * a[5] - a[4] * a[4], c1 = a[3] * a[4] - a[1] * a[5],
               c2 = a[1] * a[4] - a[2] * a[3], det = a[0] * c0 + a[1] * c1 + a[3] * c2;
  if (!(a[0] > 0)) return 0;
  if (!(det > 1e-6 * a[0] * a[0] * a[0])) return r[0] / a[0];
  const double slack = 0.2 * (most - least); /* a parabola over two even rows goes 1/8 beyond */
  return fmin(fmax((r[0] * c0 + r[1] * c1 + r[2] * c2) / det, least - slack), most + slack);
}

static int normal_at(const sct_flow *f, const double x[2]) {
  for (int64_t k = 0; k < f->walls; k++) {
    if (f->wall[k].x[0] == x[0] && f->wall[k].x[1] == x[1]) return f->wall[k].axis;
  }
  return 0;
}

void flow_walls_insulate(sct_flow *f) {
  flow_near near;
  flow_sites *s = &f->sites;
  if (!f->options.has_scalar) return;
  for (int64_t k = 0; k < s->n; k++) {
    if (s->particle[k] != SITE_WALL_NO_FLUX) continue;
    const double x[2] = {s->x[0][k], s->x[1][k]};
    s->field[FLOW_C][k] = insulated(f, x, normal_at(f, x), &near);
  }
}

/* ---- images ---- */

/* The wall within reach on one side (step -1 or 1) of cell (i, j) along a; NULL if there is none.
 */
static const flow_bound *wall_beside(const flow_mesh *m, int a, int step, int64_t i, int64_t j,
                                     const double x[2], double reach) {
  int64_t cell[2] = {i, j};
  for (;;) {
    const int64_t at[2] = {cell[0] + (a == 0 && step > 0), cell[1] + (a == 1 && step > 0)};
    const int64_t face = flow_face_below(m, a, at[0], at[1]);
    if (fabs(m->axis[a].edge[at[a]] - x[a]) >= reach) return NULL;
    const int32_t b = m->bound_of[a][face];
    if (b >= 0) return m->bound[b].kind == FACE_WALL ? &m->bound[b] : NULL;
    cell[a] += step;
  }
}

static double line_of(const flow_mesh *m, const flow_bound *b) {
  return m->axis[b->axis].edge[(b->axis == 0 ? b->i : b->j) + (b->inward < 0)];
}

static flow_image reflect(const flow_mesh *m, const flow_bound *b, const flow_image *of) {
  flow_image image = *of;
  image.x[b->axis] = 2 * line_of(m, b) - of->x[b->axis];
  for (int a = 0; a < 2; a++) image.field[a] = 2 * b->velocity[a] - of->field[a];
  if (b->has_scalar) image.field[FLOW_C] = 2 * b->scalar - of->field[FLOW_C];
  return image;
}

/* Behind an edge of a block the images of both its walls would overlap: each keeps the part that is
 * nearer to it. */
static bool is_nearest(const flow_mesh *m, const flow_bound *b, const double x[2]) {
  const int c = 1 - b->axis;
  const int64_t cell[2] = {flow_axis_find(&m->axis[0], x[0]), flow_axis_find(&m->axis[1], x[1])};
  const double depth = fabs(x[b->axis] - line_of(m, b));
  for (int step = -1; step <= 1; step += 2) {
    int64_t k[2] = {cell[0], cell[1]};
    while (k[c] >= 0 && k[c] < m->axis[c].n) {
      const double far = step > 0 ? m->axis[c].edge[k[c]] - x[c] : x[c] - m->axis[c].edge[k[c] + 1];
      if (far >= depth) break;
      if (m->fluid[flow_cell(m, k[0], k[1])]) return false;
      k[c] += step;
    }
  }
  return true;
}

int flow_wall_images(const sct_flow *f, int64_t p, int64_t i, int64_t j,
                     flow_image image[FLOW_IMAGES_MOST]) {
  const flow_mesh *m = &f->mesh;
  flow_image own = {.x = {f->particles.x[0][p], f->particles.x[1][p]}};
  for (int q = 0; q < FLOW_FIELDS; q++) {
    if (f->particles.field[q] != NULL) own.field[q] = f->particles.field[q][p];
  }
  const double reach = 1.5 * f->options.op.radius * flow_spacing(m, i, j, own.x, NULL);
  const flow_bound *wall[2][2];
  int n = 0;
  for (int a = 0; a < 2; a++) {
    for (int side = 0; side < 2; side++) {
      const flow_bound *b = wall[a][side] = wall_beside(m, a, 2 * side - 1, i, j, own.x, reach);
      if (b == NULL) continue;
      image[n] = reflect(m, b, &own);
      n += is_nearest(m, b, image[n].x);
    }
  }
  for (int k = 0; k < 4; k++) { /* corners: both orders of reflection, on average */
    const flow_bound *b = wall[0][k / 2], *c = wall[1][k % 2];
    if (b == NULL || c == NULL) continue;
    const flow_image one = reflect(m, b, &own), two = reflect(m, c, &own);
    const flow_image bc = reflect(m, c, &one), cb = reflect(m, b, &two);
    image[n] = bc;
    for (int q = 0; q < FLOW_FIELDS; q++) image[n].field[q] = (bc.field[q] + cb.field[q]) / 2;
    const int64_t ci = flow_axis_find(&m->axis[0], bc.x[0]),
                  cj = flow_axis_find(&m->axis[1], bc.x[1]);
    n += !m->fluid[flow_cell(m, ci, cj)];
  }
  return n;
}
