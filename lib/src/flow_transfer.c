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

typedef struct {
  double m[6]; /* sum w, w x, w y, w x^2, w x y, w y^2 */
  double r[FLOW_FIELDS][3];
  int n;
} fit;

static void add(fit *s, double x, double y, double w) {
  s->m[0] += w;
  s->m[1] += w * x;
  s->m[2] += w * y;
  s->m[3] += w * x * x;
  s->m[4] += w * x * y;
  s->m[5] += w * y * y;
  s->n++;
}

/* Adds the sites of one row of cells, with the values of `fields` (a bit each). */
static void add_row(const sct_flow *f, int64_t first, int64_t last, const double x[2],
                    const double per_reach[2], unsigned fields, const double *const value[],
                    fit *s) {
  const flow_sites *site = &f->sites;
  for (int64_t k = first; k < last; k++) {
    const double dx = (site->x[0][k] - x[0]) * per_reach[0];
    const double dy = (site->x[1][k] - x[1]) * per_reach[1], q2 = dx * dx + dy * dy;
    const int32_t p = site->particle[k];
    if (q2 >= 1 || p == SITE_MIRROR) continue;
    const double q = sqrt(q2), h = (1 - q) * (1 - q), w = h * h * (4 * q + 1);
    add(s, dx, dy, w);
    for (int a = 0; a < FLOW_FIELDS; a++) {
      if (!(fields & 1u << a)) continue;
      const double v = w * (p >= 0 && value[a] != NULL ? value[a][p] : site->field[a][k]);
      s->r[a][0] += v;
      s->r[a][1] += v * dx;
      s->r[a][2] += v * dy;
    }
  }
}

static void collect(const sct_flow *f, const double x[2], const double reach[2], unsigned fields,
                    const double *const value[], fit *s) {
  const flow_mesh *m = &f->mesh;
  const double per_reach[2] = {1 / reach[0], 1 / reach[1]};
  const int64_t i0 = flow_axis_find(&m->axis[0], x[0] - reach[0]);
  const int64_t i1 = flow_axis_find(&m->axis[0], x[0] + reach[0]);
  const int64_t j0 = flow_axis_find(&m->axis[1], x[1] - reach[1]);
  const int64_t j1 = flow_axis_find(&m->axis[1], x[1] + reach[1]);
  *s = (fit){.n = 0};
  for (int64_t j = j0; j <= j1; j++) {
    add_row(f, f->sites.start[flow_cell(m, i0, j)], f->sites.start[flow_cell(m, i1, j) + 1], x,
            per_reach, fields, value, s);
  }
}

/* a of the fit by Cramer's rule; a weighted mean where the sites do not span the plane. */
static double value_of(const fit *s, const double r[3]) {
  const double *m = s->m;
  const double a = m[3] * m[5] - m[4] * m[4], b = m[2] * m[4] - m[1] * m[5],
               c = m[1] * m[4] - m[2] * m[3], det = m[0] * a + m[1] * b + m[2] * c;
  if (s->n < 4 || !(det > 1e-8 * m[0] * m[0] * m[0])) return r[0] / m[0];
  return (r[0] * a + r[1] * b + r[2] * c) / det;
}

/* Widens the reach until there is something. */
static bool collect_wide(const sct_flow *f, const double x[2], const double reach[2],
                         unsigned fields, const double *const value[], fit *s) {
  double wide[2] = {reach[0], reach[1]};
  for (int k = 0; k < 6; k++) {
    collect(f, x, wide, fields, value, s);
    if (s->n > 0 && s->m[0] > 0) return true;
    for (int a = 0; a < 2; a++) wide[a] *= 1.5;
  }
  return false;
}

void flow_fit_at(const sct_flow *f, const double x[2], const double reach[2],
                 double value[FLOW_FIELDS]) {
  static const double *const none[FLOW_FIELDS] = {NULL, NULL, NULL};
  const unsigned fields = f->options.has_scalar ? 7 : 3;
  fit s;
  const bool found = collect_wide(f, x, reach, fields, none, &s);
  for (int a = 0; a < FLOW_FIELDS; a++) value[a] = found ? value_of(&s, s.r[a]) : NAN;
}

/* Value of u* or v* (direction a of the face) at the face on the lower side of cell (i, j). */
static double face_value(const sct_flow *f, int a, int64_t i, int64_t j) {
  const flow_axis *ax = &f->mesh.axis[0], *ay = &f->mesh.axis[1];
  const double x[2] = {a == 0 ? ax->edge[i] : ax->centre[i], a == 1 ? ay->edge[j] : ay->centre[j]};
  const double h[2] = {a == 0 ? ax->centre[i] - ax->centre[i - 1] : ax->width[i],
                       a == 1 ? ay->centre[j] - ay->centre[j - 1] : ay->width[j]};
  const double least = LEAST * sqrt(h[0] * h[1]);
  const double reach[2] = {REACH * fmax(h[0], least), REACH * fmax(h[1], least)};
  const double *value[FLOW_FIELDS] = {f->rows.diffused[0], f->rows.diffused[1], NULL};
  fit s;
  if (!collect_wide(f, x, reach, 1u << a, value, &s)) return 0;
  return value_of(&s, s.r[a]);
}

/* Rows of cells first .. last-1, in both directions. */
static bool transfer_rows(void *context, int64_t first, int64_t last, int t) {
  sct_flow *f = context;
  const flow_mesh *m = &f->mesh;
  const int64_t nx = m->axis[0].n;
  (void)t;
  for (int64_t c = first; c < last; c++) {
    const int64_t i = c % nx, j = c / nx;
    for (int a = 0; a < 2; a++) {
      const int64_t face = flow_face_below(m, a, i, j);
      if ((i > 0 && j > 0) &&
          (m->kind[a][face] == FACE_INNER || m->kind[a][face] == FACE_OUTFLOW)) {
        f->face[a][face] = face_value(f, a, i, j);
      }
    }
  }
  return true;
}

sct_status flow_transfer(sct_flow *f, const sct_work *work, sct_error *err) {
  const sct_work quiet = {.threads = sct_work_threads(work)};
  bool complete;
  flow_prescribe(f);
  return sct_in_pieces(f->mesh.cells, &quiet, "transfer", transfer_rows, f, &complete, err);
}
