/* flow_rows.c - the operators on the moving cloud, and diffusion by them.
 *
 * ps, ips and ipsn need sums over the neighbours only, never the weights one by one: with
 *   S = sum w, F = sum f, o = sum f r, M = sum f r r^T, q = sum w r  (f = w / r^2)
 *   P = sum f dphi, p = sum f r dphi                                 (dphi = phi_j - phi_i)
 * the Laplacian is (4 / S) (P - b . p) with b = 0 (ps) or M^-1 o (ips, [H16] eq. 20), the sum of
 * its weights (4 / S) (F - b . o), the mean of its diffusivity (S - b . q) / S (ipsn divides by
 * it), and the gradient M^-1 p (eq. 19). unit.flow.rows compares all with sct_stencil_row.
 */
#include <math.h>

#include "flow_inside.h"
#include "parallel.h"

/* Where M is flatter than this there is no gradient, and ips is ps. */
static const double FLAT = 2.5e-4;

/* Supports of an lsmps row, in spacings: the operator's own, then these. */
static const double WIDER[] = {2.6, 3};

typedef struct {
  double s, f, o[2], m[3], q[2]; /* m: xx, xy, yy */
  double p0[FLOW_FIELDS], p[FLOW_FIELDS][2];
  double inverse[3]; /* of M */
  bool flat;
} sums;

static int fields_of(const sct_flow *f) {
  return f->options.has_scalar ? FLOW_FIELDS : FLOW_C;
}

static void differences(const sct_flow *f, int64_t p, flow_near *near) {
  for (int q = 0; q < fields_of(f); q++) {
    const double own = f->particles.field[q][p], *field = f->sites.field[q];
    for (int k = 0; k < near->n; k++) near->field[q][k] = field[near->site[k]] - own;
  }
}

static void sum_moments(const flow_near *near, sums *s) {
  const double *x = near->x[0], *y = near->x[1], *f = near->f, *w = near->w;
  double sf = 0, ox = 0, oy = 0, xx = 0, xy = 0, yy = 0, qx = 0, qy = 0;
#pragma omp simd reduction(+ : sf, ox, oy, xx, xy, yy, qx, qy)
  for (int k = 0; k < near->n; k++) {
    const double fx = f[k] * x[k], fy = f[k] * y[k];
    sf += f[k];
    ox += fx;
    oy += fy;
    xx += fx * x[k];
    xy += fx * y[k];
    yy += fy * y[k];
    qx += w[k] * x[k];
    qy += w[k] * y[k];
  }
  s->f = sf;
  s->o[0] = ox;
  s->o[1] = oy;
  s->m[0] = xx;
  s->m[1] = xy;
  s->m[2] = yy;
  s->q[0] = qx;
  s->q[1] = qy;
}

static void sum_field(const flow_near *near, int q, sums *s) {
  const double *x = near->x[0], *y = near->x[1], *f = near->f, *d = near->field[q];
  double p0 = 0, px = 0, py = 0;
#pragma omp simd reduction(+ : p0, px, py)
  for (int k = 0; k < near->n; k++) {
    const double fd = f[k] * d[k];
    p0 += fd;
    px += fd * x[k];
    py += fd * y[k];
  }
  s->p0[q] = p0;
  s->p[q][0] = px;
  s->p[q][1] = py;
}

static void invert(sums *s) {
  const double det = s->m[0] * s->m[2] - s->m[1] * s->m[1], trace = s->m[0] + s->m[2];
  s->flat = !(det > FLAT * trace * trace);
  s->inverse[0] = s->flat ? 0 : s->m[2] / det;
  s->inverse[1] = s->flat ? 0 : -s->m[1] / det;
  s->inverse[2] = s->flat ? 0 : s->m[0] / det;
}

static void times_inverse(const sums *s, const double v[2], double out[2]) {
  out[0] = s->inverse[0] * v[0] + s->inverse[1] * v[1];
  out[1] = s->inverse[1] * v[0] + s->inverse[2] * v[1];
}

/* Laplacians of all fields and the sum of weights, by sums. */
static double laplace_sums(const sct_flow *f, const sums *s, double lap[FLOW_FIELDS]) {
  const sct_scheme scheme = f->options.op.scheme;
  double b[2] = {0, 0}, factor = 4 / s->s;
  if (scheme != SCT_PS) times_inverse(s, s->o, b);
  if (scheme == SCT_IPSN) {
    const double mean = (s->s - b[0] * s->q[0] - b[1] * s->q[1]) / s->s;
    if (mean > 0.3) factor /= mean;
  }
  for (int q = 0; q < fields_of(f); q++) {
    lap[q] = factor * (s->p0[q] - b[0] * s->p[q][0] - b[1] * s->p[q][1]);
  }
  return factor * (s->f - b[0] * s->o[0] - b[1] * s->o[1]);
}

/* The same by the weights of an lsmps fit, on a wider support if need be. False: there is none. */
static bool laplace_fit(const sct_flow *f, int64_t p, int64_t i, int64_t j, const double x[2],
                        double delta, flow_near *near, double lap[FLOW_FIELDS], double *weights) {
  const int tries = 1 + (int)(sizeof WIDER / sizeof WIDER[0]);
  for (int t = 0; t < tries; t++) {
    if (t > 0) {
      const double support = WIDER[t - 1] * delta;
      if (WIDER[t - 1] <= f->options.op.radius) continue;
      if (!flow_near_gather(f, i, j, x, support, near)) return false;
      flow_near_weigh(f, support, near);
      differences(f, p, near);
    }
    if (!flow_lsmps_weights(near, delta)) continue;
    *weights = 0;
    for (int k = 0; k < near->n; k++) *weights += near->q[k];
    for (int q = 0; q < fields_of(f); q++) {
      lap[q] = 0;
      for (int k = 0; k < near->n; k++) lap[q] += near->q[k] * near->field[q][k];
    }
    return true;
  }
  return false;
}

typedef struct {
  sct_flow *flow;
  double dt;
} job;

/* field + theta nu dt lap field; the stable part of the step where that is too long. */
static void diffuse(const job *to, int64_t p, const double lap[FLOW_FIELDS], double weights) {
  const sct_flow *f = to->flow;
  const flow_rows *r = &f->rows;
  r->limited[p] = 0;
  for (int q = 0; q < fields_of(f); q++) {
    const double nu = q == FLOW_C ? f->options.diffusivity : f->options.viscosity;
    double step = nu * to->dt;
    if (step * weights > 1) {
      step = 1 / weights;
      r->limited[p] |= q != FLOW_C;
    }
    r->diffused[q][p] = f->particles.field[q][p] + step * lap[q];
  }
}

static void keep(const sct_flow *f, int64_t p, const sums *s) {
  const flow_rows *r = &f->rows;
  r->density[p] = s->s;
  for (int a = 0; a < 2; a++) r->lopsided[a][p] = s->s > 0 ? s->o[a] / s->s : 0;
  for (int q = 0; q < fields_of(f); q++) {
    double g[2];
    times_inverse(s, s->p[q], g);
    r->gradient[q][0][p] = g[0];
    r->gradient[q][1][p] = g[1];
  }
}

static bool make_row(const job *to, int64_t p, int64_t i, int64_t j, flow_near *near) {
  const sct_flow *f = to->flow;
  const double x[2] = {f->particles.x[0][p], f->particles.x[1][p]};
  const double delta = flow_spacing(&f->mesh, i, j, x, NULL);
  const double support = f->options.op.radius * delta;
  double lap[FLOW_FIELDS] = {0}, weights = 0;
  sums s;
  if (!flow_near_gather(f, i, j, x, support, near)) return false;
  s.s = flow_near_weigh(f, support, near);
  differences(f, p, near);
  sum_moments(near, &s);
  for (int q = 0; q < fields_of(f); q++) sum_field(near, q, &s);
  invert(&s);
  keep(f, p, &s);
  const bool fits =
      f->options.op.scheme == SCT_LSMPS && laplace_fit(f, p, i, j, x, delta, near, lap, &weights);
  if (!fits && s.s > 0) weights = laplace_sums(f, &s, lap);
  diffuse(to, p, lap, weights);
  return true;
}

/* Rows of the particles first .. last-1, cell by cell. */
static bool make_rows(void *context, int64_t first, int64_t last, int t) {
  const job *to = context;
  const sct_flow *f = to->flow;
  flow_near near;
  (void)t;
  for (int64_t p = first; p < last; p++) {
    const int64_t i = flow_axis_find(&f->mesh.axis[0], f->particles.x[0][p]);
    const int64_t j = flow_axis_find(&f->mesh.axis[1], f->particles.x[1][p]);
    if (!make_row(to, p, i, j, &near)) return false;
  }
  return true;
}

sct_status flow_rows_make(sct_flow *f, double dt, const sct_work *work, sct_error *err) {
  const sct_work quiet = {.threads = sct_work_threads(work)};
  job to = {f, dt};
  bool complete;
  const sct_status status =
      sct_in_pieces(f->particles.n, &quiet, "rows", make_rows, &to, &complete, err);
  if (status == SCT_OK && !complete) {
    return sct_fail(err, SCT_E_UNSTABLE, -1,
                    "more than %d particles within one support at t = %g: the cloud has collapsed",
                    FLOW_NEAR_MOST, f->time);
  }
  for (int64_t p = 0; p < f->particles.n; p++) f->limited += f->rows.limited[p];
  f->updates += f->particles.n;
  return status;
}
