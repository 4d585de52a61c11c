#include "scatter/flow_case.h"

#include <inttypes.h>
#include <math.h>

#include "alloc.h"

#define PI 3.14159265358979323846

static const double STEP_HEIGHT = 0.942, UPSTREAM = 2, FINE = 0.85, FINE_REACH = 1;

void sct_flow_lines(double lower, double upper, int64_t n, double clustering, double *edge) {
  for (int64_t k = 0; k <= n; k++) {
    const double t = (double)k / (double)n;
    edge[k] = lower + (upper - lower) * (t - clustering / (2 * PI) * sin(2 * PI * t));
  }
  edge[0] = lower;
  edge[n] = upper;
}

static sct_status check(int64_t cells, double reynolds, double clustering, double end,
                        sct_error *err) {
  if (cells < 4 || cells > 4096) {
    return sct_fail(err, SCT_E_ARGUMENT, -1, "%" PRId64 " cells, needs 4 to 4096", cells);
  }
  if (!(clustering >= 0 && clustering <= 0.9)) {
    return sct_fail(err, SCT_E_ARGUMENT, -1, "clustering is %g, needs 0 to 0.9", clustering);
  }
  if (!(reynolds > 0 && end > 0 && isfinite(reynolds) && isfinite(end))) {
    return sct_fail(err, SCT_E_ARGUMENT, -1, "Reynolds number %g and end %g need to be positive",
                    reynolds, end);
  }
  return SCT_OK;
}

static sct_status take_lines(sct_flow_case *c, int a, int64_t cells, sct_error *err) {
  const sct_status status = sct_alloc(&c->edge[a], cells + 1, sizeof *c->edge[a], err);
  c->domain.cells[a] = cells;
  c->domain.edge[a] = c->edge[a];
  return status;
}

void sct_flow_case_clear(sct_flow_case *c) {
  sct_release(&c->edge[0]);
  sct_release(&c->edge[1]);
}

sct_status sct_flow_cavity(int64_t cells, double reynolds, double clustering, sct_scheme scheme,
                           double end, sct_flow_case *c, sct_error *err) {
  *c = (sct_flow_case){.options = sct_flow_default(scheme, 1 / reynolds, end)};
  sct_status status = check(cells, reynolds, clustering, end, err);
  for (int a = 0; a < 2 && status == SCT_OK; a++) {
    status = take_lines(c, a, cells, err);
    if (status == SCT_OK) sct_flow_lines(0, 1, cells, clustering, c->edge[a]);
  }
  c->side[0] =
      (sct_flow_side){.kind = SCT_FLOW_WALL, .from = {0, 1}, .to = {1, 1}, .velocity = {1, 0}};
  c->domain.side = c->side;
  c->domain.sides = 1;
  return status;
}

/* ---- step ---- */

/* u = 6 s (1 - s) over the inlet, mean 1. */
static sct_status parabola(void *context, int64_t n, const double *x, double *u, sct_error *err) {
  const double *inlet = context;
  (void)err;
  for (int64_t k = 0; k < n; k++) {
    const double s = (x[2 * k + 1] - inlet[0]) / (inlet[1] - inlet[0]);
    u[2 * k] = 6 * s * (1 - s);
    u[2 * k + 1] = 0;
  }
  return SCT_OK;
}

/* Widths from the step outwards over a length: even at first, then growing, all of the second part
 * stretched to end there. Writes width [most] and returns how many. */
static int64_t widths(double length, double fine, double growth, int64_t most, double *width) {
  const double coarse = 2 * fine;
  const int64_t even = (int64_t)ceil(fmin(FINE_REACH, length) / fine - 1e-9);
  double w = fine, total = 0;
  int64_t n = 0;
  for (; n < even && n < most; n++, total += fine) width[n] = fine;
  const double begin = total;
  for (; total < length * (1 - 1e-9) && n < most; n++, total += w) {
    w = fmin(w * growth, coarse);
    width[n] = w;
  }
  for (int64_t k = even; k < n; k++) width[k] *= (length - begin) / (total - begin);
  return n;
}

/* Lines in x of the graded mesh. */
static sct_status graded_lines(sct_flow_case *c, int64_t cells, double downstream, sct_error *err) {
  const double fine = FINE / (double)cells, growth = pow(1.03, 17 / (double)cells);
  const int64_t most = (int64_t)ceil((UPSTREAM + downstream) / fine) + 2;
  double *up = NULL, *down = NULL;
  sct_status status = sct_alloc(&up, most, sizeof *up, err);
  if (status == SCT_OK) status = sct_alloc(&down, most, sizeof *down, err);
  if (status != SCT_OK) goto done;
  const int64_t before = widths(UPSTREAM, fine, growth, most, up);
  const int64_t after = widths(downstream, fine, growth, most, down);
  status = take_lines(c, 0, before + after, err);
  if (status != SCT_OK) goto done;
  double *edge = c->edge[0];
  edge[before] = 0;
  for (int64_t k = 0; k < before; k++) edge[before - k - 1] = edge[before - k] - up[k];
  for (int64_t k = 0; k < after; k++) edge[before + k + 1] = edge[before + k] + down[k];
done:
  sct_release(&up);
  sct_release(&down);
  return status;
}

static sct_status even_lines(sct_flow_case *c, int64_t cells, double downstream, sct_error *err) {
  const int64_t before = (int64_t)UPSTREAM * cells;
  const int64_t after = (int64_t)round(downstream * (double)cells);
  const sct_status status = take_lines(c, 0, before + after, err);
  for (int64_t k = 0; status == SCT_OK && k <= before + after; k++) {
    c->edge[0][k] = (double)(k - before) / (double)cells;
  }
  return status;
}

/* Lines in y: those of the step's height, then those of the inlet's. */
static sct_status step_rows(sct_flow_case *c, int64_t cells, double clustering, sct_error *err) {
  const int64_t below = (int64_t)round(STEP_HEIGHT * (double)cells);
  const double s = STEP_HEIGHT;
  const sct_status status = take_lines(c, 1, below + cells, err);
  if (status != SCT_OK) return status;
  sct_flow_lines(0, s, below, clustering, c->edge[1]);
  sct_flow_lines(s, s + 1, cells, clustering, c->edge[1] + below);
  c->step_height = s;
  return SCT_OK;
}

sct_status sct_flow_step(int64_t cells, double reynolds, double clustering, double downstream,
                         sct_scheme scheme, double end, sct_flow_case *c, sct_error *err) {
  *c = (sct_flow_case){.options = sct_flow_default(scheme, 2 / reynolds, end)};
  c->options.shift = 0.5;
  sct_status status = check(cells, reynolds, clustering, end, err);
  if (status == SCT_OK && !(downstream >= 2 && downstream <= 1000)) {
    status = sct_fail(err, SCT_E_ARGUMENT, -1, "%g inlet heights downstream, needs 2 to 1000",
                      downstream);
  }
  if (status == SCT_OK) status = step_rows(c, cells, clustering, err);
  if (status == SCT_OK) {
    status = clustering > 0 ? graded_lines(c, cells, downstream, err)
                            : even_lines(c, cells, downstream, err);
  }
  if (status != SCT_OK) return status;
  const double left = c->edge[0][0], right = c->edge[0][c->domain.cells[0]];
  const double s = c->step_height, top = c->edge[1][c->domain.cells[1]];
  c->inlet[0] = s;
  c->inlet[1] = top;
  c->solid = (sct_flow_box){{left, 0}, {0, s}};
  c->side[0] = (sct_flow_side){.kind = SCT_FLOW_INFLOW,
                               .from = {left, s},
                               .to = {left, top},
                               .profile = parabola,
                               .context = c->inlet};
  c->side[1] = (sct_flow_side){.kind = SCT_FLOW_OUTFLOW, .from = {right, 0}, .to = {right, top}};
  c->domain.solid = &c->solid;
  c->domain.solids = 1;
  c->domain.side = c->side;
  c->domain.sides = 2;
  return SCT_OK;
}
