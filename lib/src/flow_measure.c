/* flow_measure.c - the cloud and the flow in numbers, while it runs. */
#include <math.h>
#include <string.h>

#include "alloc.h"
#include "flow_inside.h"
#include "flow_view.h"
#include "parallel.h"

/* What is measured at a particle; laid out as rows so that threads write their own. */
enum { AT_VELOCITY2, AT_TRACE, AT_XY, AT_NEAREST, AT_SPEED2, AT_COUNT };

typedef struct {
  sct_flow *flow;
  double *at; /* [particles][AT_COUNT] */
} job;

/* Tensor of ips, T_ab = (1/2) sum l r_a r_b with l = (4 / S) f (1 - b . r): half its trace, T_xy.
 */
static void tensor(const flow_near *near, double s, double *trace, double *xy) {
  double m[3] = {0}, o[2] = {0}, t[3] = {0}, b[2] = {0};
  for (int k = 0; k < near->n; k++) {
    const double x = near->x[0][k], y = near->x[1][k], f = near->f[k];
    m[0] += f * x * x;
    m[1] += f * x * y;
    m[2] += f * y * y;
    o[0] += f * x;
    o[1] += f * y;
  }
  const double det = m[0] * m[2] - m[1] * m[1];
  if (det > 2.5e-4 * s * s) {
    b[0] = (m[2] * o[0] - m[1] * o[1]) / det;
    b[1] = (m[0] * o[1] - m[1] * o[0]) / det;
  }
  for (int k = 0; k < near->n; k++) {
    const double x = near->x[0][k], y = near->x[1][k];
    const double l = 2 / s * near->f[k] * (1 - b[0] * x - b[1] * y);
    t[0] += l * x * x;
    t[1] += l * x * y;
    t[2] += l * y * y;
  }
  *trace = (t[0] + t[2]) / 2;
  *xy = t[1];
}

static bool measure_some(void *context, int64_t first, int64_t last, int thread) {
  const job *to = context;
  const sct_flow *f = to->flow;
  const flow_mesh *m = &f->mesh;
  flow_near near;
  (void)thread;
  for (int64_t p = first; p < last; p++) {
    double *at = to->at + p * AT_COUNT, o[2] = {0, 0}, nearest = INFINITY;
    const double x[2] = {f->particles.x[0][p], f->particles.x[1][p]};
    const int64_t i = flow_axis_find(&m->axis[0], x[0]), j = flow_axis_find(&m->axis[1], x[1]);
    const double delta = flow_spacing(m, i, j, x, NULL), support = f->options.op.radius * delta;
    memset(at, 0, AT_COUNT * sizeof *at);
    if (!flow_near_gather(f, i, j, x, support, &near)) return false;
    const double s = flow_near_weigh(f, support, &near);
    for (int k = 0; k < near.n; k++) {
      for (int a = 0; a < 2; a++) o[a] += near.f[k] * near.x[a][k];
      nearest = fmin(nearest, near.r2[k]);
    }
    if (s > 0) {
      at[AT_VELOCITY2] = 16 * (o[0] * o[0] + o[1] * o[1]) / (s * s) * delta * delta;
      tensor(&near, s, &at[AT_TRACE], &at[AT_XY]);
    }
    at[AT_NEAREST] = fmin(sqrt(nearest) / delta, f->options.op.radius);
    const double u = f->particles.field[0][p], v = f->particles.field[1][p];
    at[AT_SPEED2] = u * u + v * v;
  }
  return true;
}

static int ascending(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Cells without, and with more than three, particles. */
static void count_cells(const sct_flow *f, sct_flow_sample *s) {
  int64_t empty = 0, crowded = 0;
  for (int64_t c = 0; c < f->mesh.cells; c++) {
    int n = 0;
    if (!f->mesh.fluid[c]) continue;
    for (int64_t k = f->sites.start[c]; k < f->sites.start[c + 1]; k++)
      n += f->sites.particle[k] >= 0;
    empty += n == 0;
    crowded += n > 3;
  }
  s->empty = (double)empty / (double)f->mesh.fluids;
  s->crowded = (double)crowded / (double)f->mesh.fluids;
}

static void summarise(const sct_flow *f, double *at, sct_flow_sample *s) {
  const int64_t n = f->particles.n;
  double sum[AT_COUNT] = {0}, xy2 = 0, top = 0;
  for (int64_t p = 0; p < n; p++) {
    const double *row = at + p * AT_COUNT;
    for (int k = 0; k < AT_COUNT; k++) sum[k] += row[k];
    xy2 += row[AT_XY] * row[AT_XY];
    top = fmax(top, row[AT_SPEED2]);
    if (f->options.has_scalar) s->scalar += f->particles.field[FLOW_C][p] / (double)n;
  }
  s->cell_reynolds = sqrt(sum[AT_VELOCITY2] / (double)n);
  s->diffusivity_mean = sum[AT_TRACE] / (double)n;
  s->diffusivity_rms = sqrt(xy2 / (double)n);
  s->speed = sqrt(top);
  for (int64_t p = 0; p < n; p++) at[p] = at[p * AT_COUNT + AT_NEAREST]; /* p <= p AT_COUNT */
  qsort(at, (size_t)n, sizeof *at, ascending);
  s->nearest = at[n / 2];
  s->nearest_1 = at[n / 100];
}

sct_status flow_measure(sct_flow *f, const sct_work *work, sct_error *err) {
  const sct_work quiet = {.threads = sct_work_threads(work)};
  const int64_t n = f->particles.n;
  job to = {f, NULL};
  bool complete = true;
  sct_flow_sample s = {.t = f->time,
                       .particles = (double)n,
                       .divergence = f->divergence,
                       .divergence_before = f->divergence_before,
                       .limited = f->updates > 0 ? (double)f->limited / (double)f->updates : 0};
  sct_status status = sct_alloc(&to.at, n * AT_COUNT, sizeof *to.at, err);
  if (status == SCT_OK) {
    status = sct_in_pieces(n, &quiet, "measure", measure_some, &to, &complete, err);
  }
  if (status == SCT_OK && complete && n > 0) {
    summarise(f, to.at, &s);
    count_cells(f, &s);
    s.circulation = sct_flow_find_vortex(f, true).circulation;
    f->history[f->samples++] = s;
  }
  sct_release(&to.at);
  return status;
}

void flow_average(sct_flow *f, double dt) {
  f->averaged += dt;
  for (int a = 0; a < 2; a++) {
    for (int64_t k = 0; k < f->mesh.faces[a]; k++) f->mean[a][k] += dt * f->face[a][k];
  }
  for (int64_t k = 0; k < f->unknowns; k++) f->mean_phi[k] += f->phi[k]; /* p dt */
  const double q = flow_circulation(f);
  f->mean_q += dt * q;
  f->mean_q2 += dt * q * q;
}
