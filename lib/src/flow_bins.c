/* flow_bins.c - particles and all other sites, sorted by cell at every step: sums then run through
 * memory in order, and neighbours are a few runs of it. */
#include <math.h>
#include <string.h>

#include "alloc.h"
#include "flow_inside.h"

/* ---- room ---- */

static sct_status grow(double **array, int64_t n, sct_error *err) {
  return sct_realloc(array, n, sizeof **array, err);
}

static sct_status reserve_particles(sct_flow *f, flow_particles *p, int64_t n, sct_error *err) {
  sct_status status = SCT_OK;
  for (int a = 0; a < 2 && status == SCT_OK; a++) status = grow(&p->x[a], n, err);
  for (int k = 0; k < FLOW_FIELDS && status == SCT_OK; k++) {
    if (k != FLOW_C || f->options.has_scalar) status = grow(&p->field[k], n, err);
  }
  if (status == SCT_OK) p->capacity = n;
  return status;
}

static sct_status reserve_rows(sct_flow *f, int64_t n, sct_error *err) {
  flow_rows *r = &f->rows;
  sct_status status = grow(&r->density, n, err);
  if (status == SCT_OK) status = sct_realloc(&r->limited, n, sizeof *r->limited, err);
  for (int a = 0; a < 2 && status == SCT_OK; a++) status = grow(&r->lopsided[a], n, err);
  for (int k = 0; k < FLOW_FIELDS && status == SCT_OK; k++) {
    if (k == FLOW_C && !f->options.has_scalar) continue;
    status = grow(&r->diffused[k], n, err);
    for (int a = 0; a < 2 && status == SCT_OK; a++) status = grow(&r->gradient[k][a], n, err);
  }
  if (status == SCT_OK) r->capacity = n;
  return status;
}

sct_status flow_particles_reserve(sct_flow *f, int64_t n, sct_error *err) {
  if (n > f->options.max_particles) {
    return sct_fail(err, SCT_E_LIMIT, -1, "%lld particles, limit is %lld", (long long)n,
                    (long long)f->options.max_particles);
  }
  if (n <= f->particles.capacity && n <= f->rows.capacity && n <= f->spare.capacity) return SCT_OK;
  const int64_t room = n + n / 4 + 64;
  sct_status status = reserve_particles(f, &f->particles, room, err);
  if (status == SCT_OK) status = reserve_particles(f, &f->spare, room, err);
  if (status == SCT_OK) status = reserve_rows(f, room, err);
  if (status == SCT_OK) status = sct_realloc(&f->drop, room, sizeof *f->drop, err);
  return status;
}

static sct_status reserve_sites(sct_flow *f, int64_t n, sct_error *err) {
  flow_sites *s = &f->sites;
  if (n <= s->capacity) return SCT_OK;
  const int64_t room = n + n / 4 + 64;
  sct_status status = sct_realloc(&s->particle, room, sizeof *s->particle, err);
  if (status == SCT_OK) status = sct_realloc(&s->raw_cell, room, sizeof *s->raw_cell, err);
  if (status == SCT_OK) status = sct_realloc(&s->raw_particle, room, sizeof *s->raw_particle, err);
  for (int a = 0; a < 2 && status == SCT_OK; a++) status = grow(&s->x[a], room, err);
  for (int a = 0; a < 2 && status == SCT_OK; a++) status = grow(&s->raw_x[a], room, err);
  for (int k = 0; k < FLOW_FIELDS && status == SCT_OK; k++) {
    if (k == FLOW_C && !f->options.has_scalar) continue;
    status = grow(&s->field[k], room, err);
    if (status == SCT_OK) status = grow(&s->raw_field[k], room, err);
  }
  if (status == SCT_OK) s->capacity = room;
  return status;
}

void flow_bins_clear(sct_flow *f) {
  flow_sites *s = &f->sites;
  flow_particles *const both[] = {&f->particles, &f->spare};
  for (int k = 0; k < FLOW_FIELDS; k++) {
    sct_release(&s->field[k]);
    sct_release(&s->raw_field[k]);
    sct_release(&f->rows.diffused[k]);
    for (int a = 0; a < 2; a++) sct_release(&f->rows.gradient[k][a]);
    for (int p = 0; p < 2; p++) sct_release(&both[p]->field[k]);
  }
  for (int a = 0; a < 2; a++) {
    sct_release(&s->x[a]);
    sct_release(&s->raw_x[a]);
    sct_release(&f->rows.lopsided[a]);
    for (int p = 0; p < 2; p++) sct_release(&both[p]->x[a]);
  }
  sct_release(&s->particle);
  sct_release(&s->raw_cell);
  sct_release(&s->raw_particle);
  sct_release(&s->start);
  sct_release(&f->rows.density);
  sct_release(&f->rows.limited);
  sct_release(&f->drop);
}

/* ---- sites before sorting ---- */

static int fields_of(const sct_flow *f) {
  return f->options.has_scalar ? FLOW_FIELDS : FLOW_C;
}

static void add_site(sct_flow *f, const double x[2], const double field[FLOW_FIELDS],
                     int32_t particle) {
  flow_sites *s = &f->sites;
  const flow_mesh *m = &f->mesh;
  const int64_t i = flow_axis_find(&m->axis[0], x[0]), j = flow_axis_find(&m->axis[1], x[1]);
  for (int a = 0; a < 2; a++) s->raw_x[a][s->n] = x[a];
  for (int k = 0; k < fields_of(f); k++) s->raw_field[k][s->n] = field[k];
  s->raw_cell[s->n] = (int32_t)flow_cell(m, i, j);
  s->raw_particle[s->n++] = particle;
}

static void add_particles(sct_flow *f) {
  const flow_particles *p = &f->particles;
  for (int64_t k = 0; k < p->n; k++) {
    const double x[2] = {p->x[0][k], p->x[1][k]};
    double field[FLOW_FIELDS] = {0};
    for (int q = 0; q < fields_of(f); q++) field[q] = p->field[q][k];
    add_site(f, x, field, (int32_t)k);
  }
}

static void add_walls(sct_flow *f) {
  for (int64_t k = 0; k < f->walls; k++) {
    const flow_wall_point *w = &f->wall[k];
    const double field[FLOW_FIELDS] = {w->velocity[0], w->velocity[1], w->scalar};
    add_site(f, w->x, field, w->has_scalar ? SITE_WALL : SITE_WALL_NO_FLUX);
  }
}

/* Three points per row upstream of an inflow, that travel with those that enter. */
static void add_inlets(sct_flow *f) {
  const flow_mesh *m = &f->mesh;
  for (int64_t k = 0; k < f->inlets; k++) {
    const flow_bound *b = &m->bound[f->inlet[k].bound];
    const int64_t own = b->axis == 0 ? b->i : b->j, along = b->axis == 0 ? b->j : b->i;
    const double depth = m->axis[b->axis].width[own];
    const double field[FLOW_FIELDS] = {b->velocity[0], b->velocity[1], b->scalar};
    double x[2];
    x[1 - b->axis] = m->axis[1 - b->axis].centre[along];
    for (int back = 1; back <= 3; back++) {
      const double line = m->axis[b->axis].edge[own + (b->inward < 0)];
      x[b->axis] = line + b->inward * (f->inlet[k].travelled - back * depth);
      add_site(f, x, field, SITE_INFLOW);
    }
  }
}

static sct_status add_images(sct_flow *f, sct_error *err) {
  flow_image image[FLOW_IMAGES_MOST];
  sct_status status = SCT_OK;
  for (int64_t p = 0; p < f->particles.n && status == SCT_OK; p++) {
    const int32_t c = f->sites.raw_cell[p];
    const int n = flow_wall_images(f, p, c % f->mesh.axis[0].n, c / f->mesh.axis[0].n, image);
    status = reserve_sites(f, f->sites.n + n, err);
    for (int k = 0; k < n && status == SCT_OK; k++) {
      add_site(f, image[k].x, image[k].field, SITE_MIRROR);
    }
  }
  return status;
}

/* ---- sorting ---- */

/* start [cells + 1] from the cells of the raw sites; then each finds its place. */
static void sort_sites(sct_flow *f) {
  flow_sites *s = &f->sites;
  memset(s->start, 0, (size_t)(f->mesh.cells + 1) * sizeof *s->start);
  for (int64_t k = 0; k < s->n; k++) s->start[s->raw_cell[k] + 1]++;
  for (int64_t c = 0; c < f->mesh.cells; c++) s->start[c + 1] += s->start[c];
  for (int64_t k = 0; k < s->n; k++) {
    const int32_t to = s->start[s->raw_cell[k]]++;
    for (int a = 0; a < 2; a++) s->x[a][to] = s->raw_x[a][k];
    for (int q = 0; q < fields_of(f); q++) s->field[q][to] = s->raw_field[q][k];
    s->particle[to] = s->raw_particle[k];
  }
  for (int64_t c = f->mesh.cells; c > 0; c--) s->start[c] = s->start[c - 1];
  s->start[0] = 0;
}

/* Particles are numbered as their sites are. */
static void follow(sct_flow *f) {
  flow_sites *s = &f->sites;
  flow_particles *p = &f->particles;
  int32_t n = 0;
  for (int64_t k = 0; k < s->n; k++) {
    if (s->particle[k] < 0) continue;
    for (int a = 0; a < 2; a++) p->x[a][n] = s->x[a][k];
    for (int q = 0; q < fields_of(f); q++) p->field[q][n] = s->field[q][k];
    s->particle[k] = n++;
  }
}

sct_status flow_bins_fill(sct_flow *f, sct_error *err) {
  sct_status status = reserve_sites(f, f->particles.n + f->walls + 3 * f->inlets, err);
  if (status == SCT_OK) status = flow_particles_reserve(f, f->particles.n, err);
  if (status != SCT_OK) return status;
  f->sites.n = 0;
  add_particles(f);
  if (f->options.walls == SCT_FLOW_WALL_MIRROR) status = add_images(f, err);
  if (status == SCT_OK) status = reserve_sites(f, f->sites.n + f->walls + 3 * f->inlets, err);
  if (status != SCT_OK) return status;
  add_walls(f);
  add_inlets(f);
  sort_sites(f);
  follow(f);
  return SCT_OK;
}
