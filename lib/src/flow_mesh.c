/* flow_mesh.c - lines, cells and faces. What those are: flow_domain.c. */
#include "flow_mesh.h"

#include <inttypes.h>
#include <math.h>

#include "alloc.h"

static const char axis_name[] = {'x', 'y'};

static sct_status check_lines(const sct_flow_domain *d, int a, sct_error *err) {
  enum { CELLS_MAX = 1 << 14 };
  const int64_t n = d->cells[a];
  if (n < 2 || n > CELLS_MAX) {
    return sct_fail(err, SCT_E_ARGUMENT, -1, "mesh has %" PRId64 " cells in %c, needs 2 to %d", n,
                    axis_name[a], CELLS_MAX);
  }
  const double *edge = d->edge[a], least = 1e-6 * fabs(edge[n] - edge[0]);
  for (int64_t k = 0; k <= n; k++) {
    if (!(fabs(edge[k]) < 1e100) || (k > 0 && !(edge[k] > edge[k - 1]))) {
      return sct_fail(err, SCT_E_ARGUMENT, -1,
                      "line %" PRId64 " of the mesh in %c is at %g, needs ascending places", k,
                      axis_name[a], edge[k]);
    }
    if (k > 0 && edge[k] - edge[k - 1] < least) {
      return sct_fail(err, SCT_E_ARGUMENT, -1,
                      "line %" PRId64
                      " of the mesh in %c is %g beyond the one before, needs 1e-6 of "
                      "the extent, %g",
                      k, axis_name[a], edge[k] - edge[k - 1], least);
    }
  }
  return SCT_OK;
}

/* Lines with a margin of cells as wide as those beside it. */
static void lay_lines(const double *edge, int64_t n, flow_axis *a) {
  for (int64_t k = 0; k <= n; k++) a->edge[k + FLOW_PAD] = edge[k];
  for (int64_t k = 1; k <= FLOW_PAD; k++) {
    a->edge[FLOW_PAD - k] = edge[0] - (double)k * (edge[1] - edge[0]);
    a->edge[FLOW_PAD + n + k] = edge[n] + (double)k * (edge[n] - edge[n - 1]);
  }
  for (int64_t k = 0; k < a->n; k++) {
    a->centre[k] = (a->edge[k] + a->edge[k + 1]) / 2;
    a->width[k] = a->edge[k + 1] - a->edge[k];
  }
}

static double least_width(const flow_axis *a) {
  double least = INFINITY;
  for (int64_t k = 0; k < a->n; k++) least = fmin(least, a->width[k]);
  return least;
}

/* A table of even buckets, about as narrow as the narrowest cell, from which a cell is found in a
 * step or two. */
static sct_status fill_buckets(flow_axis *a, sct_error *err) {
  const double length = a->edge[a->n] - a->edge[0];
  const double wanted = ceil(length / least_width(a)), most = 8 * (double)a->n;
  a->buckets = (int64_t)fmin(wanted, most);
  a->per_bucket = (double)a->buckets / length;
  const sct_status status = sct_alloc(&a->bucket, a->buckets, sizeof *a->bucket, err);
  int32_t i = 0;
  for (int64_t b = 0; status == SCT_OK && b < a->buckets; b++) {
    const double x = a->edge[0] + (double)b / a->per_bucket;
    while (i + 1 < a->n && x >= a->edge[i + 1]) i++;
    a->bucket[b] = i;
  }
  return status;
}

static sct_status build_axis(const double *edge, int64_t n, flow_axis *a, sct_error *err) {
  a->n = n + INT64_C(2) * FLOW_PAD;
  sct_status status = sct_alloc(&a->edge, a->n + 1, sizeof *a->edge, err);
  if (status == SCT_OK) status = sct_alloc(&a->centre, a->n, sizeof *a->centre, err);
  if (status == SCT_OK) status = sct_alloc(&a->width, a->n, sizeof *a->width, err);
  if (status != SCT_OK) return status;
  lay_lines(edge, n, a);
  return fill_buckets(a, err);
}

static bool is_even(const flow_axis *a) {
  for (int64_t k = 1; k < a->n; k++) {
    if (fabs(a->width[k] - a->width[0]) > 1e-9 * a->width[0]) return false;
  }
  return true;
}

static sct_status take_faces(flow_mesh *m, sct_error *err) {
  sct_status status = sct_alloc_zero(&m->fluid, m->cells, sizeof *m->fluid, err);
  for (int a = 0; a < 2 && status == SCT_OK; a++) {
    m->faces[a] = (m->axis[0].n + (a == 0)) * (m->axis[1].n + (a == 1));
    status = sct_alloc_zero(&m->kind[a], m->faces[a], sizeof *m->kind[a], err);
    if (status != SCT_OK) return status;
    status = sct_alloc(&m->bound_of[a], m->faces[a], sizeof *m->bound_of[a], err);
    for (int64_t f = 0; status == SCT_OK && f < m->faces[a]; f++) m->bound_of[a][f] = -1;
  }
  return status;
}

sct_status flow_mesh_build(const sct_flow_domain *d, flow_mesh *m, sct_error *err) {
  sct_status status = SCT_OK;
  for (int a = 0; a < 2 && status == SCT_OK; a++) {
    status = check_lines(d, a, err);
    if (status == SCT_OK) status = build_axis(d->edge[a], d->cells[a], &m->axis[a], err);
  }
  if (status != SCT_OK) return status;
  m->cells = m->axis[0].n * m->axis[1].n;
  m->is_uniform = is_even(&m->axis[0]) && is_even(&m->axis[1]);
  m->spacing = sqrt(least_width(&m->axis[0]) * least_width(&m->axis[1]));
  return take_faces(m, err);
}

double flow_spacing(const flow_mesh *m, int64_t i, int64_t j, const double x[2], double thin[2]) {
  if (m->is_uniform) {
    if (thin != NULL) thin[0] = thin[1] = 0;
    return m->spacing;
  }
  double sx, sy;
  const double wx = flow_axis_width(&m->axis[0], i, x[0], &sx);
  const double wy = flow_axis_width(&m->axis[1], j, x[1], &sy);
  if (thin != NULL) { /* ln n_t = -ln wx - ln wy */
    thin[0] = -sx / wx;
    thin[1] = -sy / wy;
  }
  return sqrt(wx * wy);
}

void flow_mesh_clear(flow_mesh *m) {
  for (int a = 0; a < 2; a++) {
    sct_release(&m->axis[a].edge);
    sct_release(&m->axis[a].centre);
    sct_release(&m->axis[a].width);
    sct_release(&m->axis[a].bucket);
    sct_release(&m->kind[a]);
    sct_release(&m->bound_of[a]);
    sct_release(&m->ghost[a]);
    sct_release(&m->copy[a]);
  }
  sct_release(&m->fluid);
  sct_release(&m->bound);
}
