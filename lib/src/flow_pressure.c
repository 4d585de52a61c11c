/* flow_pressure.c - the projection: div grad phi = div u* on the cells, u = u* - grad phi.
 *
 * phi is pressure times dt, so the matrix does not know the step and is factored once. Five points;
 * no flux through prescribed faces, phi = 0 on outflow faces, half a cell away. A part of the fluid
 * without outflow determines phi up to a constant: one diagonal entry of it is doubled. */
#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "alloc.h"
#include "flow_inside.h"

/* Area of a face and distance between the places that the difference is taken of. */
static double conductance(const flow_mesh *m, int a, int64_t i, int64_t j) {
  const flow_axis *normal = &m->axis[a], *across = &m->axis[1 - a];
  const int64_t k = a == 0 ? i : j, along = a == 0 ? j : i;
  const int64_t face = flow_face_below(m, a, i, j);
  const double area = across->width[along];
  if (m->kind[a][face] == FACE_INNER) return area / (normal->centre[k] - normal->centre[k - 1]);
  if (m->kind[a][face] != FACE_OUTFLOW) return 0;
  const bool above = m->fluid[flow_cell(m, i, j)];
  return area / (normal->width[above ? k : k - 1] / 2);
}

/* ---- matrix ---- */

static sct_status number_unknowns(sct_flow *f, sct_error *err) {
  const sct_status status = sct_alloc(&f->unknown, f->mesh.cells, sizeof *f->unknown, err);
  f->unknowns = 0;
  for (int64_t c = 0; status == SCT_OK && c < f->mesh.cells; c++) {
    f->unknown[c] = f->mesh.fluid[c] ? (int32_t)f->unknowns++ : -1;
  }
  return status;
}

/* The rows' lower triangles: neighbours to the left and below, and the diagonal. */
static void fill_matrix(const sct_flow *f, sct_csr *a) {
  const flow_mesh *m = &f->mesh;
  const int64_t nx = m->axis[0].n;
  int64_t n = 0;
  for (int64_t c = 0; c < m->cells; c++) {
    if (f->unknown[c] < 0) continue;
    const int64_t i = c % nx, j = c / nx;
    const double left = conductance(m, 0, i, j), below = conductance(m, 1, i, j);
    a->start[f->unknown[c]] = n;
    if (m->kind[1][flow_face_below(m, 1, i, j)] == FACE_INNER) {
      a->column[n] = f->unknown[c - nx];
      a->value[n++] = -below;
    }
    if (m->kind[0][flow_face_below(m, 0, i, j)] == FACE_INNER) {
      a->column[n] = f->unknown[c - 1];
      a->value[n++] = -left;
    }
    a->column[n] = f->unknown[c];
    a->value[n++] = left + below + conductance(m, 0, i + 1, j) + conductance(m, 1, i, j + 1);
  }
  a->start[a->rows] = n;
}

/* ---- parts of the fluid ---- */

/* Marks the part of the fluid that holds a cell: part [cells], queue [unknowns]. */
static void flood(const flow_mesh *m, int64_t first, int32_t part, int32_t *parts, int32_t *queue) {
  const int64_t nx = m->axis[0].n;
  int64_t from = 0, to = 0;
  parts[first] = part;
  queue[to++] = (int32_t)first;
  while (from < to) {
    const int64_t c = queue[from++];
    const int64_t around[4] = {c - 1, c + 1, c - nx, c + nx}; /* the margin is solid */
    for (int k = 0; k < 4; k++) {
      if (!m->fluid[around[k]] || parts[around[k]] >= 0) continue;
      parts[around[k]] = part;
      queue[to++] = (int32_t)around[k];
    }
  }
}

/* Flux into a part through prescribed faces, its size, and whether it has an outflow. */
static bool is_open(const flow_mesh *m, const int32_t *parts, int32_t part, double *flux,
                    double *size) {
  bool open = false;
  *flux = *size = 0;
  for (int64_t k = 0; k < m->bounds; k++) {
    const flow_bound *b = &m->bound[k];
    if (parts[b->cell] != part) continue;
    const double area = m->axis[1 - b->axis].width[b->axis == 0 ? b->j : b->i];
    open |= b->kind == FACE_OUTFLOW;
    if (b->kind != FACE_INFLOW) continue;
    *flux += b->inward * b->mean * area;
    *size += fabs(b->mean) * area;
  }
  return open;
}

/* Doubles one diagonal entry of every closed part, which inflows must leave in balance. */
static sct_status pin_parts(const sct_flow *f, sct_csr *a, int32_t *parts, int32_t *queue,
                            sct_error *err) {
  const flow_mesh *m = &f->mesh;
  int32_t count = 0;
  for (int64_t c = 0; c < m->cells; c++) parts[c] = -1;
  for (int64_t c = 0; c < m->cells; c++) {
    double flux, size;
    if (!m->fluid[c] || parts[c] >= 0) continue;
    flood(m, c, count, parts, queue);
    if (is_open(m, parts, count++, &flux, &size)) continue;
    if (fabs(flux) > 1e-9 * size) {
      return sct_fail(err, SCT_E_ARGUMENT, -1,
                      "%g flows into the domain and nothing out, needs an outflow", flux);
    }
    a->value[a->start[f->unknown[c] + 1] - 1] *= 2;
  }
  return SCT_OK;
}

sct_status flow_pressure_build(sct_flow *f, sct_error *err) {
  sct_csr *a = NULL;
  int32_t *parts = NULL, *queue = NULL;
  sct_status status = number_unknowns(f, err);
  if (status != SCT_OK) return status;
  status = sct_csr_new(f->unknowns, f->unknowns, 3 * f->unknowns, &a, err);
  if (status == SCT_OK) status = sct_alloc(&parts, f->mesh.cells, sizeof *parts, err);
  if (status == SCT_OK) status = sct_alloc(&queue, f->unknowns, sizeof *queue, err);
  if (status == SCT_OK) status = sct_alloc(&f->right, f->unknowns, sizeof *f->right, err);
  if (status == SCT_OK) status = sct_alloc_zero(&f->phi, f->unknowns, sizeof *f->phi, err);
  if (status != SCT_OK) goto done;
  fill_matrix(f, a);
  status = pin_parts(f, a, parts, queue, err);
  if (status == SCT_OK) status = sct_cholesky_build(a, &f->factor, err);
done:
  sct_release(&parts);
  sct_release(&queue);
  sct_csr_free(&a);
  return status;
}

/* ---- projection ---- */

void flow_prescribe(sct_flow *f) {
  for (int64_t k = 0; k < f->mesh.bounds; k++) {
    const flow_bound *b = &f->mesh.bound[k];
    if (b->kind != FACE_OUTFLOW) f->face[b->axis][b->face] = b->mean;
  }
}

/* Flux out of a cell. */
static double outflux(const sct_flow *f, int64_t i, int64_t j) {
  const flow_mesh *m = &f->mesh;
  const double *u = f->face[0], *v = f->face[1];
  return (u[flow_face_below(m, 0, i + 1, j)] - u[flow_face_below(m, 0, i, j)]) *
             m->axis[1].width[j] +
         (v[flow_face_below(m, 1, i, j + 1)] - v[flow_face_below(m, 1, i, j)]) *
             m->axis[0].width[i];
}

/* Fluxes of all cells into right; root mean square and largest divergence. */
static void diverge(sct_flow *f, double *rms, double *most) {
  const flow_mesh *m = &f->mesh;
  const int64_t nx = m->axis[0].n;
  double sum = 0, top = 0;
  for (int64_t c = 0; c < m->cells; c++) {
    if (f->unknown[c] < 0) continue;
    const int64_t i = c % nx, j = c / nx;
    const double flux = outflux(f, i, j);
    const double d = flux / (m->axis[0].width[i] * m->axis[1].width[j]);
    f->right[f->unknown[c]] = -flux;
    sum += d * d;
    top = fmax(top, fabs(d));
  }
  *rms = sqrt(sum / (double)f->unknowns);
  *most = top;
}

static double phi_at(const sct_flow *f, int64_t c) {
  return f->unknown[c] >= 0 ? f->phi[f->unknown[c]] : 0;
}

/* change = -grad phi, which is added to the faces. */
static void correct(sct_flow *f) {
  const flow_mesh *m = &f->mesh;
  for (int a = 0; a < 2; a++) {
    const int64_t back = a == 0 ? 1 : m->axis[0].n;
    for (int64_t j = 1; j < m->axis[1].n; j++) {
      for (int64_t i = 1; i < m->axis[0].n; i++) {
        const int64_t face = flow_face_below(m, a, i, j), c = flow_cell(m, i, j);
        const uint8_t kind = m->kind[a][face];
        if (kind != FACE_INNER && kind != FACE_OUTFLOW) continue;
        const double area = m->axis[1 - a].width[a == 0 ? j : i];
        const double change =
            -(phi_at(f, c) - phi_at(f, c - back)) * conductance(m, a, i, j) / area;
        f->change[a][face] = change;
        f->face[a][face] += change;
      }
    }
  }
}

/* Values beyond the walls: no slip for the velocity, the inner neighbour's for the change. */
static void fill_ghosts(sct_flow *f) {
  const flow_mesh *m = &f->mesh;
  for (int a = 0; a < 2; a++) {
    double *face = f->face[a], *change = f->change[a];
    for (int64_t k = 0; k < m->copies[a]; k++) {
      change[m->copy[a][k].to] = change[m->copy[a][k].from];
    }
    for (int64_t k = 0; k < m->ghosts[a]; k++) {
      const flow_ghost *g = &m->ghost[a][k];
      face[g->to] = g->sign * face[g->from] + g->offset;
      change[g->to] = change[g->from];
    }
  }
}

sct_status flow_project(sct_flow *f, sct_error *err) {
  double rms;
  diverge(f, &f->divergence_before, &rms);
  const sct_status status = sct_cholesky_solve(f->factor, f->right, f->phi, err);
  if (status != SCT_OK) return status;
  correct(f);
  diverge(f, &rms, &f->divergence);
  fill_ghosts(f);
  return SCT_OK;
}
