#include "flow_domain.h"

#include <inttypes.h>
#include <math.h>

#include "alloc.h"

/* ---- boxes ---- */

/* The line of the mesh at x, or -1. */
static int64_t line_at(const flow_axis *a, double x) {
  const double extent = a->edge[a->n] - a->edge[0];
  if (!isfinite(x)) return -1;
  const int64_t i = flow_axis_find(a, x);
  if (fabs(x - a->edge[i]) <= 1e-9 * extent) return i;
  return fabs(x - a->edge[i + 1]) <= 1e-9 * extent ? i + 1 : -1;
}

static sct_status box_lines(const flow_mesh *m, const sct_flow_box *box, const char *what,
                            int64_t number, int64_t lower[2], int64_t upper[2], sct_error *err) {
  for (int a = 0; a < 2; a++) {
    lower[a] = line_at(&m->axis[a], box->lower[a]);
    upper[a] = line_at(&m->axis[a], box->upper[a]);
    if (lower[a] >= FLOW_PAD && upper[a] > lower[a] && upper[a] <= m->axis[a].n - FLOW_PAD) {
      continue;
    }
    return sct_fail(err, SCT_E_ARGUMENT, -1,
                    "%s box %" PRId64
                    " goes from %g to %g in %c, needs ascending lines of the mesh",
                    what, number, box->lower[a], box->upper[a], "xy"[a]);
  }
  return SCT_OK;
}

static sct_status paint(flow_mesh *m, const sct_flow_box *boxes, int64_t n, const char *what,
                        uint8_t value, sct_error *err) {
  for (int64_t k = 0; k < n; k++) {
    int64_t lower[2] = {0}, upper[2] = {0};
    const sct_status status = box_lines(m, &boxes[k], what, k, lower, upper, err);
    if (status != SCT_OK) return status;
    for (int64_t j = lower[1]; j < upper[1]; j++) {
      for (int64_t i = lower[0]; i < upper[0]; i++) m->fluid[flow_cell(m, i, j)] = value;
    }
  }
  return SCT_OK;
}

static sct_status paint_cells(const sct_flow_domain *d, flow_mesh *m, sct_error *err) {
  const sct_flow_box all = {
      {m->axis[0].edge[FLOW_PAD], m->axis[1].edge[FLOW_PAD]},
      {m->axis[0].edge[m->axis[0].n - FLOW_PAD], m->axis[1].edge[m->axis[1].n - FLOW_PAD]}};
  const bool whole = d->fluids == 0;
  sct_status status = paint(m, whole ? &all : d->fluid, whole ? 1 : d->fluids, "fluid", 1, err);
  if (status == SCT_OK) status = paint(m, d->solid, d->solids, "solid", 0, err);
  m->fluids = 0;
  for (int64_t c = 0; c < m->cells; c++) m->fluids += m->fluid[c];
  if (status == SCT_OK && m->fluids == 0) {
    status = sct_fail(err, SCT_E_ARGUMENT, -1, "no cell of the mesh is fluid");
  }
  return status;
}

/* ---- thin blocks ---- */

/* Solid between fluid, along a line of cells, must be two particle spacings thick. */
static sct_status check_line_thick(const flow_mesh *m, int a, int64_t line, sct_error *err) {
  const flow_axis *along = &m->axis[a], *across = &m->axis[1 - a];
  double thick = INFINITY; /* of the solid since the last fluid */
  for (int64_t k = 0; k < along->n; k++) {
    const int64_t c = a == 0 ? flow_cell(m, k, line) : flow_cell(m, line, k);
    const double delta = sqrt(along->width[k] * across->width[line]);
    if (!m->fluid[c]) {
      thick += along->width[k];
    } else if (thick > 0 && thick < 2 * delta * (1 - 1e-9)) {
      return sct_fail(err, SCT_E_ARGUMENT, -1,
                      "a block that ends at %c = %g is %g thick, needs two particle spacings, %g",
                      "xy"[a], along -> edge[k], thick, 2 * delta);
    } else {
      thick = 0;
    }
  }
  return SCT_OK;
}

static sct_status check_thick(const flow_mesh *m, sct_error *err) {
  for (int a = 0; a < 2; a++) {
    for (int64_t line = FLOW_PAD; line < m->axis[1 - a].n - FLOW_PAD; line++) {
      const sct_status status = check_line_thick(m, a, line, err);
      if (status != SCT_OK) return status;
    }
  }
  return SCT_OK;
}

/* ---- bounds ---- */

/* Calls with every pair of cells that share a face. */
static void each_face(flow_mesh *m, void (*see)(flow_mesh *m, int a, int64_t i, int64_t j)) {
  for (int a = 0; a < 2; a++) {
    for (int64_t j = a == 1; j < m->axis[1].n; j++) {
      for (int64_t i = a == 0; i < m->axis[0].n; i++) see(m, a, i, j);
    }
  }
}

static void see_face(flow_mesh *m, int a, int64_t i, int64_t j) {
  const bool above = m->fluid[flow_cell(m, i, j)];
  const bool below = m->fluid[flow_cell(m, i - (a == 0), j - (a == 1))];
  const int64_t f = flow_face_below(m, a, i, j);
  m->kind[a][f] = above && below ? FACE_INNER : above || below ? FACE_WALL : FACE_NONE;
  if (above == below) return;
  if (m->bound != NULL) {
    const int32_t bi = (int32_t)(i - (below && a == 0)), bj = (int32_t)(j - (below && a == 1));
    m->bound[m->bounds] = (flow_bound){.axis = a,
                                       .face = f,
                                       .cell = flow_cell(m, bi, bj),
                                       .side = -1,
                                       .i = bi,
                                       .j = bj,
                                       .inward = above ? 1 : -1,
                                       .kind = FACE_WALL};
    m->bound_of[a][f] = (int32_t)m->bounds;
  }
  m->bounds++;
}

static sct_status find_bounds(flow_mesh *m, sct_error *err) {
  each_face(m, see_face); /* counts */
  const sct_status status = sct_alloc_zero(&m->bound, m->bounds, sizeof *m->bound, err);
  m->bounds = 0;
  if (status == SCT_OK) each_face(m, see_face);
  return status;
}

/* ---- sides ---- */

/* The faces of a side: direction of their normal, line they lie on, first and last cell along. */
typedef struct {
  int a;
  int64_t line, first, last;
} stretch;

static sct_status side_stretch(const flow_mesh *m, const sct_flow_side *s, int64_t number,
                               stretch *st, sct_error *err) {
  for (int a = 0; a < 2; a++) {
    const int b = 1 - a;
    const int64_t line = line_at(&m->axis[a], s->from[a]), to = line_at(&m->axis[a], s->to[a]);
    int64_t p = line_at(&m->axis[b], s->from[b]), q = line_at(&m->axis[b], s->to[b]);
    if (line < 0 || line != to || p < 0 || q < 0 || p == q) continue;
    *st = (stretch){a, line, p < q ? p : q, (p < q ? q : p) - 1};
    return SCT_OK;
  }
  return sct_fail(err, SCT_E_ARGUMENT, -1,
                  "side %" PRId64
                  " goes from (%g, %g) to (%g, %g), needs two places on a line of "
                  "the mesh where lines cross",
                  number, s->from[0], s->from[1], s->to[0], s->to[1]);
}

/* Velocity at the centre of a face and its mean normal part by Simpson's rule, which is exact for
 * parabolas. */
static sct_status prescribe(const flow_mesh *m, const sct_flow_side *s, flow_bound *b,
                            sct_error *err) {
  const int along = 1 - b->axis;
  const flow_axis *axis = &m->axis[along], *normal = &m->axis[b->axis];
  const int64_t k = along == 0 ? b->i : b->j, own = along == 0 ? b->j : b->i;
  const double line = normal->edge[own + (b->inward < 0)];
  const double at[3] = {axis->edge[k], axis->centre[k], axis->edge[k + 1]};
  double x[3][2] = {{0}}, u[3][2];
  for (int p = 0; p < 3; p++) {
    x[p][b->axis] = line;
    x[p][along] = at[p];
    u[p][0] = s->velocity[0];
    u[p][1] = s->velocity[1];
  }
  if (s->profile != NULL) {
    const sct_status status = s->profile(s->context, 3, &x[0][0], &u[0][0], err);
    if (status != SCT_OK) return status;
  }
  for (int p = 0; p < 3; p++) {
    if (isfinite(u[p][0]) && isfinite(u[p][1])) continue;
    return sct_fail(err, SCT_E_NOT_FINITE, -1, "velocity at (%g, %g) of a side is not finite",
                    x[p][0], x[p][1]);
  }
  b->velocity[0] = u[1][0];
  b->velocity[1] = u[1][1];
  b->mean = (u[0][b->axis] + 4 * u[1][b->axis] + u[2][b->axis]) / 6;
  return SCT_OK;
}

static sct_status lay_side(flow_mesh *m, const sct_flow_side *s, int64_t number, sct_error *err) {
  static const flow_face faces[] = {FACE_WALL, FACE_INFLOW, FACE_OUTFLOW};
  stretch st = {0};
  sct_status status = side_stretch(m, s, number, &st, err);
  if (status != SCT_OK) return status;
  if ((unsigned)s->kind >= SCT_FLOW_SIDE_COUNT || (s->has_scalar && !isfinite(s->scalar))) {
    return sct_fail(err, SCT_E_ARGUMENT, -1, "side %" PRId64 " is of no kind or value", number);
  }
  for (int64_t k = st.first; k <= st.last && status == SCT_OK; k++) {
    const int64_t f =
        st.a == 0 ? flow_face_below(m, 0, st.line, k) : flow_face_below(m, 1, k, st.line);
    if (m->bound_of[st.a][f] < 0) {
      return sct_fail(err, SCT_E_ARGUMENT, -1, "side %" PRId64 " leaves the boundary of the fluid",
                      number);
    }
    flow_bound *b = &m->bound[m->bound_of[st.a][f]];
    b->side = number;
    b->kind = faces[s->kind];
    b->has_scalar = s->has_scalar || b->kind == FACE_INFLOW;
    b->scalar = s->has_scalar ? s->scalar : 0;
    m->kind[st.a][f] = (uint8_t)b->kind;
    status = prescribe(m, s, b, err);
    const double slip = fabs(b->velocity[1 - b->axis]) + fabs(b->velocity[b->axis]);
    if (status == SCT_OK && b->kind == FACE_WALL && fabs(b->mean) > 1e-12 * slip) {
      status = sct_fail(err, SCT_E_ARGUMENT, -1,
                        "wall %" PRId64 " moves through its own plane with %g, needs 0", number,
                        b->mean);
    }
    if (b->kind == FACE_WALL) b->mean = 0;
  }
  return status;
}

/* ---- ghosts ---- */

/* Value beyond the wall for face (i, j) of direction a, which has no fluid beside it: from the face
 * one row back, in whose cells the wall is `away` (+1: the wall is above them). False if there is
 * no fluid there either. */
static bool ghost_from(const flow_mesh *m, int a, int64_t i, int64_t j, int away, flow_ghost *g) {
  const int64_t si = i - (a == 1 ? away : 0), sj = j - (a == 0 ? away : 0);
  if (si < 0 || sj < 0 || si > m->axis[0].n - (a == 1) || sj > m->axis[1].n - (a == 0))
    return false;
  const int64_t from = flow_face_below(m, a, si, sj);
  if (m->kind[a][from] == FACE_NONE) return false;
  double wall = 0;
  int walls = 0;
  bool open = false;
  for (int back = 0; back < 2; back++) { /* the two cells that the source face is between */
    const int64_t ci = si - (a == 0 && back), cj = sj - (a == 1 && back);
    const int64_t f = a == 0 ? flow_face_below(m, 1, ci, cj + (away > 0))
                             : flow_face_below(m, 0, ci + (away > 0), cj);
    const int32_t b = m->bound_of[1 - a][f];
    if (b < 0 || !m->fluid[flow_cell(m, ci, cj)]) continue;
    open |= m->bound[b].kind == FACE_OUTFLOW;
    wall += m->bound[b].velocity[a];
    walls++;
  }
  if (walls == 0) return false;
  *g = (flow_ghost){(int32_t)flow_face_below(m, a, i, j), (int32_t)from, open ? 1 : -1,
                    open ? 0 : 2 * wall / walls};
  return true;
}

/* Counts, or with room writes, the ghosts of direction a. */
static int64_t lay_ghosts(const flow_mesh *m, int a, flow_ghost *out) {
  int64_t n = 0;
  for (int64_t j = 0; j < m->axis[1].n + (a == 1); j++) {
    for (int64_t i = 0; i < m->axis[0].n + (a == 0); i++) {
      flow_ghost g;
      if (m->kind[a][flow_face_below(m, a, i, j)] != FACE_NONE) continue;
      if (!ghost_from(m, a, i, j, 1, &g) && !ghost_from(m, a, i, j, -1, &g)) continue;
      if (out != NULL) out[n] = g;
      n++;
    }
  }
  return n;
}

/* Increments on prescribed faces are those of the face across the cell. */
static int64_t lay_copies(const flow_mesh *m, int a, flow_ghost *out) {
  int64_t n = 0;
  for (int64_t k = 0; k < m->bounds; k++) {
    const flow_bound *b = &m->bound[k];
    if (b->axis != a || b->kind == FACE_OUTFLOW) continue;
    const int64_t step = b->inward > 0;
    const int64_t from = a == 0 ? flow_face_below(m, 0, b->i + step, b->j)
                                : flow_face_below(m, 1, b->i, b->j + step);
    if (out != NULL) out[n] = (flow_ghost){(int32_t)b->face, (int32_t)from, 1, 0};
    n++;
  }
  return n;
}

static sct_status find_ghosts(flow_mesh *m, sct_error *err) {
  sct_status status = SCT_OK;
  for (int a = 0; a < 2 && status == SCT_OK; a++) {
    m->ghosts[a] = lay_ghosts(m, a, NULL);
    m->copies[a] = lay_copies(m, a, NULL);
    status = sct_alloc(&m->ghost[a], m->ghosts[a], sizeof *m->ghost[a], err);
    if (status == SCT_OK) status = sct_alloc(&m->copy[a], m->copies[a], sizeof *m->copy[a], err);
    if (status != SCT_OK) break;
    lay_ghosts(m, a, m->ghost[a]);
    lay_copies(m, a, m->copy[a]);
  }
  return status;
}

sct_status flow_domain_lay(const sct_flow_domain *d, flow_mesh *m, sct_error *err) {
  sct_status status = paint_cells(d, m, err);
  if (status == SCT_OK) status = check_thick(m, err);
  if (status == SCT_OK) status = find_bounds(m, err);
  for (int64_t k = 0; k < d->sides && status == SCT_OK; k++) {
    status = lay_side(m, &d->side[k], k, err);
  }
  return status == SCT_OK ? find_ghosts(m, err) : status;
}
