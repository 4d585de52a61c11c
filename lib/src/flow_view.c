/* flow_view.c - what a flow has come to: stream function, profiles, vortex, reattachment. */
#include "flow_view.h"

#include <math.h>
#include <string.h>

/* Velocity at a face: of the last step, or the mean. */
static double face_at(const sct_flow *f, bool now, int a, int64_t face) {
  return now || f->averaged == 0 ? f->face[a][face] : f->mean[a][face] / f->averaged;
}

static bool is_fluid_face(const flow_mesh *m, int a, int64_t face) {
  return m->kind[a][face] != FACE_NONE;
}

/* u dy through an x-face; 0 in solid, whose ghosts are none of the flow. */
static double flux_right(const sct_flow *f, bool now, int64_t i, int64_t j) {
  const int64_t face = flow_face_below(&f->mesh, 0, i, j);
  if (!is_fluid_face(&f->mesh, 0, face)) return 0;
  return face_at(f, now, 0, face) * f->mesh.axis[1].width[j];
}

enum { PADS = 2 * FLOW_PAD }; /* of both sides */

double flow_circulation(const sct_flow *f) {
  const flow_mesh *m = &f->mesh;
  double least = 0;
  for (int64_t i = FLOW_PAD; i <= m->axis[0].n - FLOW_PAD; i++) {
    double psi = 0;
    for (int64_t j = FLOW_PAD; j < m->axis[1].n - FLOW_PAD; j++) {
      psi += flux_right(f, true, i, j);
      least = fmin(least, psi);
    }
  }
  return -least;
}

/* psi at node (i, j), of all lines below. */
static double psi_at(const sct_flow *f, bool now, int64_t i, int64_t j) {
  double psi = 0;
  for (int64_t k = FLOW_PAD; k < j; k++) psi += flux_right(f, now, i, k);
  return psi;
}

/* Least value of the parabola through three places, and where; the middle one if it is none. */
static double parabola(const double x[3], const double y[3], double *at) {
  const double d0 = (y[1] - y[0]) / (x[1] - x[0]), d1 = (y[2] - y[1]) / (x[2] - x[1]);
  const double c = (d1 - d0) / (x[2] - x[0]);
  *at = x[1];
  if (!(c > 0)) return y[1];
  *at = (x[0] + x[1]) / 2 - d0 / (2 * c);
  return y[0] + d0 * (*at - x[0]) + c * (*at - x[0]) * (*at - x[1]);
}

/* The node with the least psi. */
static double least_node(const sct_flow *f, bool now, int64_t node[2]) {
  const flow_mesh *m = &f->mesh;
  double least = INFINITY;
  for (int64_t i = FLOW_PAD; i <= m->axis[0].n - FLOW_PAD; i++) {
    double psi = 0;
    for (int64_t j = FLOW_PAD; j <= m->axis[1].n - FLOW_PAD; j++) {
      if (psi < least) {
        least = psi;
        node[0] = i;
        node[1] = j;
      }
      psi += flux_right(f, now, i, j);
    }
  }
  return least;
}

sct_flow_vortex sct_flow_find_vortex(const sct_flow *f, bool now) {
  const flow_mesh *m = &f->mesh;
  int64_t node[2] = {FLOW_PAD, FLOW_PAD};
  const double psi = least_node(f, now, node);
  double at[2], low[2];
  for (int a = 0; a < 2; a++) {
    const double *edge = m->axis[a].edge;
    const int64_t k = node[a];
    at[a] = edge[k];
    low[a] = psi;
    if (k <= FLOW_PAD || k >= m->axis[a].n - FLOW_PAD) continue;
    double x[3], y[3];
    for (int p = 0; p < 3; p++) {
      x[p] = edge[k + p - 1];
      y[p] = psi_at(f, now, node[0] + (a == 0 ? p - 1 : 0), node[1] + (a == 1 ? p - 1 : 0));
    }
    low[a] = parabola(x, y, &at[a]);
  }
  return (sct_flow_vortex){at[0], at[1], psi - low[0] + psi - low[1] - psi};
}

static double pressure_at(const sct_flow *f, bool now, int64_t c) {
  const int32_t k = f->unknown[c];
  if (k < 0) return NAN;
  if (!now && f->averaged > 0) return f->mean_phi[k] / f->averaged;
  return f->step > 0 ? f->phi[k] / f->step : 0;
}

void sct_flow_mesh(const sct_flow *f, bool now, double *pressure, double *stream, double *u,
                   double *v) {
  const flow_mesh *m = &f->mesh;
  const int64_t nx = m->axis[0].n - PADS, ny = m->axis[1].n - PADS;
  double *const out[2] = {u, v};
  for (int64_t j = 0; j < ny && pressure != NULL; j++) {
    for (int64_t i = 0; i < nx; i++) {
      pressure[j * nx + i] = pressure_at(f, now, flow_cell(m, i + FLOW_PAD, j + FLOW_PAD));
    }
  }
  for (int64_t i = 0; i <= nx && stream != NULL; i++) {
    double psi = 0;
    for (int64_t j = 0; j <= ny; j++) {
      stream[j * (nx + 1) + i] = psi;
      psi += flux_right(f, now, i + FLOW_PAD, j + FLOW_PAD);
    }
  }
  for (int a = 0; a < 2; a++) {
    const int64_t wide = nx + (a == 0), high = ny + (a == 1);
    for (int64_t k = 0; k < wide * high && out[a] != NULL; k++) {
      const int64_t face = flow_face_below(m, a, k % wide + FLOW_PAD, k / wide + FLOW_PAD);
      out[a][k] = is_fluid_face(m, a, face) ? face_at(f, now, a, face) : 0;
    }
  }
}

/* ---- sections ---- */

int64_t sct_flow_section_most(const sct_flow *f, int along) {
  return f->mesh.axis[1 - along].n - PADS + 2;
}

/* Component `along` at the line's place `at` in row k of cells across it: linear between faces. */
static double section_value(const sct_flow *f, bool now, int along, int64_t i, double at,
                            int64_t k) {
  const flow_axis *a = &f->mesh.axis[along];
  const double s = (at - a->edge[i]) / a->width[i];
  const int64_t low =
      along == 0 ? flow_face_below(&f->mesh, 0, i, k) : flow_face_below(&f->mesh, 1, k, i);
  const int64_t high = along == 0 ? low + 1 : low + f->mesh.axis[0].n;
  return (1 - s) * face_at(f, now, along, low) + s * face_at(f, now, along, high);
}

/* Velocity of the wall between the cell and the solid beyond it on the line, 0 if it is none. */
static double wall_value(const sct_flow *f, int along, int64_t i, int64_t k, bool above) {
  const flow_mesh *m = &f->mesh;
  const int across = 1 - along;
  const int64_t face = along == 0 ? flow_face_below(m, across, i, k + above)
                                  : flow_face_below(m, across, k + above, i);
  const int32_t b = m->bound_of[across][face];
  return b >= 0 ? m->bound[b].velocity[along] : 0;
}

int64_t sct_flow_section(const sct_flow *f, bool now, int along, double at, double *s,
                         double *value) {
  const flow_mesh *m = &f->mesh;
  const flow_axis *across = &m->axis[1 - along];
  const int64_t i = flow_axis_find(&m->axis[along], at);
  int64_t n = 0, last = -1;
  for (int64_t k = 0; k < across->n; k++) {
    if (!m->fluid[along == 0 ? flow_cell(m, i, k) : flow_cell(m, k, i)]) continue;
    if (n == 0) {
      s[n] = across->edge[k];
      value[n++] = wall_value(f, along, i, k, false);
    }
    s[n] = across->centre[k];
    value[n++] = section_value(f, now, along, i, at, k);
    last = k;
  }
  if (last < 0) return 0;
  s[n] = across->edge[last + 1];
  value[n++] = wall_value(f, along, i, last, true);
  return n;
}

/* ---- reattachment ---- */

/* Shear at the wall below, from u of the two first rows: zero at the wall, a parabola. */
static double shear(const sct_flow *f, bool now, int64_t i, int64_t j) {
  const flow_axis *ay = &f->mesh.axis[1];
  const double y1 = ay->centre[j] - ay->edge[j], y2 = ay->centre[j + 1] - ay->edge[j];
  const double u1 = face_at(f, now, 0, flow_face_below(&f->mesh, 0, i, j));
  const double u2 = face_at(f, now, 0, flow_face_below(&f->mesh, 0, i, j + 1));
  return (u1 * y2 * y2 - u2 * y1 * y1) / (y1 * y2 * (y2 - y1));
}

double sct_flow_reattachment(const sct_flow *f, bool now, double x, double y) {
  const flow_mesh *m = &f->mesh;
  const flow_axis *ax = &m->axis[0];
  const int64_t j = flow_axis_find(&m->axis[1], y + 1e-9 * m->spacing);
  double before = 0;
  int64_t last = -1;
  for (int64_t i = flow_axis_find(ax, x) + 1; i <= ax->n - FLOW_PAD; i++) {
    if (m->kind[0][flow_face_below(m, 0, i, j)] == FACE_NONE) break;
    const double tau = shear(f, now, i, j);
    if (last >= 0 && before < 0 && tau >= 0) {
      return ax->edge[last] + (ax->edge[i] - ax->edge[last]) * before / (before - tau);
    }
    before = tau;
    last = i;
  }
  return NAN;
}
