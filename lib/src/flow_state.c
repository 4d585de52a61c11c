/* flow_state.c - a flow as bytes and back: for long runs that are interrupted.
 *
 * One walk over all that changes (each_part) writes and reads it, so that the two cannot differ.
 * What a step computes anew (sites, rows) is not in it; the order of the particles is, because sums
 * depend on it in the last bit. */
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "flow_inside.h"

/* Changes whenever what is in the bytes does. */
enum { FORMAT = 2 };

typedef struct {
  uint64_t magic, format, owner, size, sum; /* owner: of the flow; sum: of all that follows */
  int64_t particles, samples, snapshots;
} head;

static const uint64_t MAGIC = 0x31776f6c66746373u; /* "sctflow1" */

/* Fowler, Noll and Vo 1991, by words of eight bytes. */
static uint64_t hash(uint64_t h, const void *bytes, size_t size) {
  const unsigned char *p = bytes;
  for (; size >= 8; size -= 8, p += 8) {
    uint64_t word;
    memcpy(&word, p, 8);
    h = (h ^ word) * 0x100000001b3u;
    h ^= h >> 29;
  }
  for (; size > 0; size--) h = (h ^ *p++) * 0x100000001b3u;
  return h;
}

/* ---- whose bytes ---- */

static uint64_t hash_bounds(uint64_t h, const flow_mesh *m) {
  for (int64_t k = 0; k < m->bounds; k++) {
    const flow_bound *b = &m->bound[k];
    const double values[] = {b->mean, b->velocity[0], b->velocity[1], b->scalar};
    const int32_t marks[] = {(int32_t)b->kind, b->has_scalar};
    h = hash(hash(h, values, sizeof values), marks, sizeof marks);
  }
  return h;
}

static uint64_t owner_of(const sct_flow *f) {
  const sct_flow_options *o = &f->options;
  const double numbers[] = {o->viscosity,    o->courant,   o->diffusion_number,
                            o->shift,        o->jitter,    o->end,
                            o->average_from, o->op.radius, o->diffusivity};
  const int64_t counts[] = {(int64_t)o->seed,      o->samples,        o->saves,
                            (int64_t)o->op.scheme, (int64_t)o->walls, o->has_scalar,
                            f->mesh.axis[0].n,     f->mesh.axis[1].n};
  uint64_t h = hash(0xcbf29ce484222325u, numbers, sizeof numbers);
  h = hash(h, counts, sizeof counts);
  h = hash(h, o->op.kernel->name, strlen(o->op.kernel->name));
  h = hash(h, f->save, (size_t)o->saves * sizeof *f->save);
  for (int a = 0; a < 2; a++) {
    h = hash(h, f->mesh.axis[a].edge, (size_t)(f->mesh.axis[a].n + 1) * sizeof(double));
  }
  h = hash(h, f->mesh.fluid, (size_t)f->mesh.cells);
  return hash_bounds(h, &f->mesh);
}

/* ---- the walk ---- */

typedef struct {
  unsigned char *at; /* NULL: only counts */
  bool reads;
  size_t size;
} stream;

static void part(stream *s, void *memory, int64_t n, size_t size) {
  const size_t bytes = (size_t)n * size;
  if (s->at != NULL && bytes > 0) {
    memcpy(s->reads ? memory : s->at + s->size, s->reads ? s->at + s->size : memory, bytes);
  }
  s->size += bytes;
}

static void each_number(stream *s, sct_flow *f) {
  double *const numbers[] = {&f->time,       &f->step,     &f->divergence_before,
                             &f->divergence, &f->averaged, &f->mean_q,
                             &f->mean_q2};
  int64_t *const counts[] = {&f->steps,   &f->inserted, &f->removed,
                             &f->updates, &f->limited,  &f->next_stop};
  for (size_t k = 0; k < sizeof numbers / sizeof numbers[0]; k++) {
    part(s, numbers[k], 1, sizeof(double));
  }
  for (size_t k = 0; k < sizeof counts / sizeof counts[0]; k++) {
    part(s, counts[k], 1, sizeof(int64_t));
  }
}

static void each_part(stream *s, sct_flow *f) {
  const int64_t n = f->particles.n;
  each_number(s, f);
  for (int64_t k = 0; k < f->inlets; k++) part(s, &f->inlet[k].travelled, 1, sizeof(double));
  for (int a = 0; a < 2; a++) {
    part(s, f->particles.x[a], n, sizeof(double));
    part(s, f->face[a], f->mesh.faces[a], sizeof(double));
    part(s, f->mean[a], f->mesh.faces[a], sizeof(double));
  }
  for (int q = 0; q < FLOW_FIELDS; q++) {
    if (f->particles.field[q] != NULL) part(s, f->particles.field[q], n, sizeof(double));
  }
  part(s, f->phi, f->unknowns, sizeof(double));
  part(s, f->mean_phi, f->unknowns, sizeof(double));
  part(s, f->history, f->samples, sizeof *f->history);
}

static void each_snapshot(stream *s, flow_snapshot *shot, bool has_scalar) {
  part(s, shot->x, 2 * shot->n, sizeof(double));
  part(s, shot->u, 2 * shot->n, sizeof(double));
  if (has_scalar) part(s, shot->c, shot->n, sizeof(double));
}

static void walk(stream *s, sct_flow *f) {
  for (int64_t k = 0; k < f->snapshots; k++) {
    part(s, &f->snapshot[k].time, 1, sizeof(double));
    part(s, &f->snapshot[k].n, 1, sizeof(int64_t));
  }
  each_part(s, f);
  for (int64_t k = 0; k < f->snapshots; k++) {
    each_snapshot(s, &f->snapshot[k], f->options.has_scalar);
  }
}

/* ---- save and load ---- */

static uint64_t sum_of(const head *h, const unsigned char *parts) {
  const int64_t counts[] = {h->particles, h->samples, h->snapshots};
  return hash(hash(0, counts, sizeof counts), parts, h->size);
}

sct_status sct_flow_save(const sct_flow *flow, void **bytes, size_t *size, sct_error *err) {
  sct_flow *f = (sct_flow *)flow; /* written only where the stream reads */
  stream count = {0};
  unsigned char *memory = NULL;
  *bytes = NULL;
  walk(&count, f);
  *size = sizeof(head) + count.size;
  const sct_status status = sct_alloc(&memory, (int64_t)*size, 1, err);
  if (status != SCT_OK) return status;
  stream out = {.at = memory + sizeof(head)};
  walk(&out, f);
  head h = {.magic = MAGIC,
            .format = FORMAT,
            .owner = owner_of(f),
            .size = count.size,
            .particles = f->particles.n,
            .samples = f->samples,
            .snapshots = f->snapshots};
  h.sum = sum_of(&h, memory + sizeof h);
  memcpy(memory, &h, sizeof h);
  *bytes = memory;
  return SCT_OK;
}

static sct_status check_head(const sct_flow *f, const unsigned char *bytes, size_t size, head *h,
                             sct_error *err) {
  if (size >= sizeof *h) memcpy(h, bytes, sizeof *h);
  if (size < sizeof *h || h->magic != MAGIC || h->format != FORMAT) {
    return sct_fail(err, SCT_E_ARGUMENT, -1, "these bytes are no saved flow of this version");
  }
  if (h->owner != owner_of(f)) {
    return sct_fail(err, SCT_E_ARGUMENT, -1, "the saved flow is another one");
  }
  if (h->size != size - sizeof *h || h->sum != sum_of(h, bytes + sizeof *h) || h->particles < 0 ||
      h->samples < 0 || h->samples > f->options.samples + 1 || h->snapshots < 0 ||
      h->snapshots > f->options.saves) {
    return sct_fail(err, SCT_E_ARGUMENT, -1, "the saved flow is damaged");
  }
  return SCT_OK;
}

static void drop_snapshots(sct_flow *f) {
  for (int64_t k = 0; k < f->snapshots; k++) {
    sct_release(&f->snapshot[k].x);
    sct_release(&f->snapshot[k].u);
    sct_release(&f->snapshot[k].c);
  }
  f->snapshots = 0;
}

/* Room for what the head and the sizes of the snapshots promise. */
static sct_status make_room(sct_flow *f, const head *h, const unsigned char *bytes,
                            sct_error *err) {
  drop_snapshots(f);
  sct_status status = flow_particles_reserve(f, h->particles, err);
  for (int64_t k = 0; k < h->snapshots && status == SCT_OK; k++) {
    flow_snapshot *s = &f->snapshot[f->snapshots++];
    *s = (flow_snapshot){0};
    memcpy(&s->n, bytes + (size_t)k * 16 + 8, sizeof s->n);
    status = sct_alloc(&s->x, 2 * s->n, sizeof *s->x, err);
    if (status == SCT_OK) status = sct_alloc(&s->u, 2 * s->n, sizeof *s->u, err);
    if (status == SCT_OK && f->options.has_scalar) {
      status = sct_alloc(&s->c, s->n, sizeof *s->c, err);
    }
  }
  f->particles.n = h->particles;
  f->samples = h->samples;
  return status;
}

sct_status sct_flow_load(sct_flow *f, const void *bytes, size_t size, sct_error *err) {
  head h = {0};
  const unsigned char *p = bytes;
  sct_status status = check_head(f, p, size, &h, err);
  if (status != SCT_OK) return status;
  if ((size_t)h.snapshots * 16 > h.size) {
    return sct_fail(err, SCT_E_ARGUMENT, -1, "the saved flow is damaged");
  }
  status = make_room(f, &h, p + sizeof h, err);
  if (status != SCT_OK) return status;
  stream count = {0}, in = {.at = (unsigned char *)p + sizeof h, .reads = true};
  walk(&count, f);
  if (count.size != h.size) {
    return sct_fail(err, SCT_E_ARGUMENT, -1, "the saved flow is damaged");
  }
  walk(&in, f);
  return flow_reserve_views(f, err);
}
