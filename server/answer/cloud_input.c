#include "cloud_input.h"

#include <string.h>

#include "cloud_kind.h"

/* Orders the points along memory: sets order, place and the coordinates by place. */
static bool number_points(task *t, cloud_input *c) {
  int64_t n = c->cloud.n;
  int dim = c->cloud.dim;
  const sct_cloud posted = {dim, n, c->posted};
  double *x = task_take(t, n * dim, sizeof *x);
  c->order = task_take(t, n, sizeof *c->order);
  c->place = task_take(t, n, sizeof *c->place);
  if (!x || !c->order || !c->place) return false;
  if (sct_cloud_order(&posted, c->order, &t->error)) return false;
  for (int64_t k = 0; k < n; k++) {
    const double *from = c->posted + (int64_t)c->order[k] * dim;
    for (int a = 0; a < dim; a++) x[k * dim + a] = from[a];
    c->place[c->order[k]] = (int32_t)k;
  }
  c->cloud.x = x;
  t->cloud = c;
  return true;
}

static bool read_either(task *t, const item *it, cloud_input *c) {
  static const char *const forms[] = {"points", "lattice", "spacing", "groups", "normals", NULL};
  static const char *const lattice_form[] = {"lattice", NULL};
  item lattice = item_member(it, "lattice");
  if (lattice.doc) {
    c->is_lattice = true;
    item_pointer(&lattice, c->pointer);
    return read_object(t, it, lattice_form) & cloud_lattice_read(t, &lattice, c);
  }
  if (doc_member(it->doc, "points")) return cloud_posted_read(t, it, c);
  if (read_object(t, it, forms)) complain(t, it, "has no points, needs points or a lattice");
  return false;
}

/* An array that came by reference (.npy, CSV, a result) is the points. */
static bool read_bare(task *t, const item *it, cloud_input *c) {
  doc points = *it->doc;
  doc cloud = {.kind = DOC_OBJECT, .child = &points, .count = 1};
  item whole = *it;
  points.key = "points";
  points.next = NULL;
  if (points.rank == 1) { /* a column: points on a line */
    points.rank = 2;
    points.shape[1] = 1;
  }
  whole.doc = &cloud;
  return cloud_posted_read(t, &whole, c) && number_points(t, c);
}

bool cloud_input_read(task *t, const item *it, cloud_input *c) {
  *c = (cloud_input){0};
  if (!read_required(t, it)) return false;
  if (it->doc->by_href && it->doc->kind == DOC_NUMBERS) return read_bare(t, it, c);
  if (it->doc->kind != DOC_OBJECT) return read_object(t, it, NULL);
  return read_either(t, it, c) && number_points(t, c);
}

/* Questions */

bool cloud_input_group(task *t, const item *at, cloud_input *c, const char *name,
                       point_group *group) {
  return c->is_lattice ? cloud_lattice_group(t, at, c, name, group)
                       : cloud_posted_group(t, at, c, name, group);
}

static void mark(const cloud_input *c, const point_group *group, uint8_t value, uint8_t *mask) {
  for (int64_t k = 0; k < group->n; k++) mask[c->place[group->index[k]]] = value;
}

uint8_t *cloud_input_interior(task *t, cloud_input *c) {
  uint8_t *mask = task_take(t, c->cloud.n, 1);
  if (!mask) return NULL;
  memset(mask, 1, (size_t)c->cloud.n);
  if (c->is_lattice) {
    point_group boundary;
    if (!cloud_lattice_group(t, NULL, c, sct_side_name(SCT_SIDE_BOUNDARY), &boundary)) return NULL;
    mark(c, &boundary, 0, mask);
  }
  for (int64_t k = 0; k < c->groups; k++) mark(c, &c->group[k], 0, mask);
  if (!memchr(mask, 1, (size_t)c->cloud.n)) memset(mask, 1, (size_t)c->cloud.n);
  return mask;
}

double *cloud_input_restore(task *t, const cloud_input *c, const double *value, int components) {
  double *out = task_take(t, c->cloud.n * components, sizeof *out);
  if (!out) return NULL;
  for (int64_t k = 0; k < c->cloud.n; k++) {
    double *to = out + (int64_t)c->order[k] * components;
    for (int a = 0; a < components; a++) to[a] = value[k * components + a];
  }
  return out;
}

static int64_t client_number(const cloud_input *c, int64_t place) {
  return place >= 0 && place < c->cloud.n ? c->order[place] : place;
}

void cloud_input_translate(const cloud_input *c, sct_error *error) {
  int64_t kept = error->count < SCT_ERROR_POINTS ? error->count : SCT_ERROR_POINTS;
  for (int64_t k = 0; k < kept; k++) error->points[k] = client_number(c, error->points[k]);
  error->point = client_number(c, error->point);
}
