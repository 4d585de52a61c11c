/* flow_transfer.c - from particles to faces, by moving linear least squares.
 *
 * At a face a + b dx + c dy is fitted to the particles and wall points around, weight
 * (1 - q)^4 (4 q + 1), q = |(dx / R_x, dy / R_y)|, and a taken: linear fields are exact. What was
 * tried instead is worse or unstable: weighted means, no wall points (lib/README.md). */
#include <math.h>

#include "flow_inside.h"
#include "parallel.h"

/* Support in cell widths; a direction whose cells are much narrower than the other's gets more. */
static const double REACH = 1.7, LEAST = 0.8;

enum { NEAR_MOST = FLOW_NEAR_MOST };

/* The sites within an ellipse, offsets by its half axes. */
typedef struct {
  int n;
  double x[NEAR_MOST + 8], y[NEAR_MOST + 8], q2[NEAR_MOST + 8], w[NEAR_MOST + 8];
  int32_t site[NEAR_MOST + 8];
} ellipse;

typedef struct {
  double m[6]; /* sum w, w x, w y, w x^2, w x y, w y^2 */
  int n;
} fit;

/* Beyond NEAR_MOST sites the others are left out: the fit is good without them. */
static void gather(const sct_flow *f, const double x[2], const double reach[2], ellipse *e) {
  const flow_mesh *m = &f->mesh;
  const flow_sites *s = &f->sites;
  const double px = 1 / reach[0], py = 1 / reach[1];
  const int64_t i0 = flow_axis_find(&m->axis[0], x[0] - reach[0]);
  const int64_t i1 = flow_axis_find(&m->axis[0], x[0] + reach[0]);
  const int64_t j0 = flow_axis_find(&m->axis[1], x[1] - reach[1]);
  const int64_t j1 = flow_axis_find(&m->axis[1], x[1] + reach[1]);
  int n = 0;
  for (int64_t j = j0; j <= j1; j++) {
    const int64_t first = s->start[flow_cell(m, i0, j)];
    int64_t end = s->start[flow_cell(m, i1, j) + 1];
    if (end > first + NEAR_MOST - n) end = first + NEAR_MOST - n;
    for (int64_t k = first; k < end; k++) {
      const double dx = (s->x[0][k] - x[0]) * px, dy = (s->x[1][k] - x[1]) * py;
      e->x[n] = dx;
      e->y[n] = dy;
      e->q2[n] = dx * dx + dy * dy;
      e->site[n] = (int32_t)k;
      n += (e->q2[n] < 1) & (s->particle[k] != SITE_MIRROR);
    }
  }
  e->n = n;
}

/* Weights and their moments. */
static void weigh(ellipse *e, fit *s) {
  double m0 = 0, mx = 0, my = 0, xx = 0, xy = 0, yy = 0;
  for (int k = 0; k < e->n; k++) {
    const double q = sqrt(e->q2[k]);  // NOLINT(clang-analyzer-core.CallAndMessage): set below n
    const double h = (1 - q) * (1 - q);
    e->w[k] = h * h * (4 * q + 1);
  }
#pragma omp simd reduction(+ : m0, mx, my, xx, xy, yy)
  for (int k = 0; k < e->n; k++) {
    const double wx = e->w[k] * e->x[k], wy = e->w[k] * e->y[k];
    m0 += e->w[k];
    mx += wx;
    my += wy;
    xx += wx * e->x[k];
    xy += wx * e->y[k];
    yy += wy * e->y[k];
  }
  *s = (fit){{m0, mx, my, xx, xy, yy}, e->n};
}

/* Cofactors of the fit's matrix, and its determinant. */
static double determinant(const double m[6], double cofactor[3]) {
  cofactor[0] = m[3] * m[5] - m[4] * m[4];
  cofactor[1] = m[2] * m[4] - m[1] * m[5];
  cofactor[2] = m[1] * m[4] - m[2] * m[3];
  return m[0] * cofactor[0] + m[1] * cofactor[1] + m[2] * cofactor[2];
}

/* Do the sites carry a linear fit? */
static bool spans(const fit *s) {
  double cofactor[3];
  return s->n >= 4 && determinant(s->m, cofactor) > 1e-6 * s->m[0] * s->m[0] * s->m[0];
}

/* a of the fit to a field of the sites, by Cramer's rule; a weighted mean where they carry none. */
static double value_of(const ellipse *e, const fit *s, const double *field) {
  double cofactor[3], r0 = 0, rx = 0, ry = 0;
#pragma omp simd reduction(+ : r0, rx, ry)
  for (int k = 0; k < e->n; k++) {
    const double v = e->w[k] * field[e->site[k]];
    r0 += v;
    rx += v * e->x[k];
    ry += v * e->y[k];
  }
  if (!spans(s)) return r0 / s->m[0];
  const double det = determinant(s->m, cofactor);
  return (r0 * cofactor[0] + rx * cofactor[1] + ry * cofactor[2]) / det;
}

/* Widens the reach until a linear fit is carried, which next to an outflow takes more; if it never
 * is, anything there will do. False if there is nothing. */
static bool collect(const sct_flow *f, const double x[2], const double reach[2], ellipse *e,
                    fit *s) {
  double wide[2] = {reach[0], reach[1]};
  for (int k = 0; k < 6; k++) {
    gather(f, x, wide, e);
    weigh(e, s);
    if (spans(s) || (k >= 2 && s->n > 0 && s->m[0] > 0)) return true;
    for (int a = 0; a < 2; a++) wide[a] *= 1.5;
  }
  return false;
}

void flow_fit_at(const sct_flow *f, const double x[2], const double reach[2],
                 double value[FLOW_FIELDS]) {
  ellipse e;
  fit s;
  const bool found = collect(f, x, reach, &e, &s);
  for (int q = 0; q < FLOW_FIELDS; q++) {
    const double *field = f->sites.field[q];
    value[q] = found && field != NULL ? value_of(&e, &s, field) : NAN;
  }
}

/* Value of u* or v* (direction a of the face) at the face on the lower side of cell (i, j). */
static double face_value(const sct_flow *f, int a, int64_t i, int64_t j, ellipse *e) {
  const flow_axis *ax = &f->mesh.axis[0], *ay = &f->mesh.axis[1];
  const double x[2] = {a == 0 ? ax->edge[i] : ax->centre[i], a == 1 ? ay->edge[j] : ay->centre[j]};
  const double h[2] = {a == 0 ? ax->centre[i] - ax->centre[i - 1] : ax->width[i],
                       a == 1 ? ay->centre[j] - ay->centre[j - 1] : ay->width[j]};
  const double least = LEAST * sqrt(h[0] * h[1]);
  const double reach[2] = {REACH * fmax(h[0], least), REACH * fmax(h[1], least)};
  fit s;
  return collect(f, x, reach, e, &s) ? value_of(e, &s, f->sites.field[a]) : 0;
}

/* Rows of cells first .. last-1, in both directions. */
static bool transfer_rows(void *context, int64_t first, int64_t last, int t) {
  sct_flow *f = context;
  const flow_mesh *m = &f->mesh;
  const int64_t nx = m->axis[0].n;
  ellipse e;
  (void)t;
  for (int64_t c = first; c < last; c++) {
    const int64_t i = c % nx, j = c / nx;
    for (int a = 0; a < 2; a++) {
      const int64_t face = flow_face_below(m, a, i, j);
      if ((i > 0 && j > 0) &&
          (m->kind[a][face] == FACE_INNER || m->kind[a][face] == FACE_OUTFLOW)) {
        f->face[a][face] = face_value(f, a, i, j, &e);
      }
    }
  }
  return true;
}

/* The sites of particles get their u*, v*: what comes from now on is about these. */
static void take_diffused(sct_flow *f) {
  const flow_sites *s = &f->sites;
  for (int64_t k = 0; k < s->n; k++) {
    if (s->particle[k] < 0) continue;
    for (int a = 0; a < 2; a++) s->field[a][k] = f->rows.diffused[a][s->particle[k]];
  }
}

sct_status flow_transfer(sct_flow *f, const sct_work *work, sct_error *err) {
  const sct_work quiet = {.threads = sct_work_threads(work)};
  bool complete;
  take_diffused(f);
  flow_prescribe(f);
  return sct_in_pieces(f->mesh.cells, &quiet, "transfer", transfer_rows, f, &complete, err);
}
