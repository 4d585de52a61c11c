#include "cloud_input.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Posted points */

static bool rows_are_points(task *t, const item *it, const numbers *points) {
  if (points->rows == 0) {
    complain(t, it, "is empty, needs at least one point");
    return false;
  }
  if (points->columns < 1 || points->columns > SCT_DIM_MAX) {
    complain(t, it, "has points of %lld coordinates, needs 1 to %d", (long long)points->columns,
             SCT_DIM_MAX);
    return false;
  }
  if (points->rows > t->limits->points) {
    complain(t, it, "has %lld points, at most %lld are allowed", (long long)points->rows,
             (long long)t->limits->points);
    return false;
  }
  return true;
}

static bool read_points(task *t, const item *it, cloud_input *c) {
  numbers points = {0};
  bool is_flat = item_rank(it) == 1 && it->doc->count > 0; /* of a 1-D cloud: [x, x, ...] */
  if (!read_required(t, it) || !read_numbers(t, it, is_flat ? 1 : 2, &points)) return false;
  if (!rows_are_points(t, it, &points)) return false;
  c->cloud.dim = (int)points.columns;
  c->cloud.n = points.rows;
  c->posted = points.data;
  return true;
}

static bool read_group(task *t, const item *it, int64_t points, point_group *group) {
  numbers index = {0};
  if (!read_integers(t, it, 0, points - 1, &index)) return false;
  int32_t *copy = task_take(t, index.rows, sizeof *copy);
  if (!copy) return false;
  for (int64_t k = 0; k < index.rows; k++) copy[k] = (int32_t)index.data[k];
  *group = (point_group){.name = it->key, .n = index.rows, .index = copy};
  return true;
}

static bool read_groups(task *t, const item *it, cloud_input *c) {
  if (!it->doc) return true;
  if (!read_object(t, it, NULL)) return false;
  c->group = task_zeros(t, it->doc->count, sizeof *c->group);
  if (!c->group) return false;
  bool good = true;
  for (const doc *m = it->doc->child; m; m = m->next) {
    item member = {.doc = m, .up = it, .key = m->key};
    point_group *group = &c->group[c->groups++];
    group->name = m->key;
    good &= read_group(t, &member, c->cloud.n, group);
  }
  return good;
}

static point_group *find_group(const cloud_input *c, const char *name) {
  for (int64_t k = 0; k < c->groups; k++) {
    if (!strcmp(c->group[k].name, name)) return &c->group[k];
  }
  return NULL;
}

static bool normals_are_nonzero(task *t, const item *it, int dim, const numbers *normals) {
  bool good = true;
  for (int64_t k = 0; k < normals->rows; k++) {
    double size = 0;
    for (int a = 0; a < dim; a++) size += fabs(normals->data[k * dim + a]);
    if (size > 0) continue;
    item row = item_element(it, NULL, k);
    complain(t, item_rank(it) == 2 ? &row : it, "is a zero vector, needs a direction");
    good = false;
  }
  return good;
}

bool read_normals(task *t, const item *it, int64_t n, int dim, numbers *normals) {
  numbers read = {0};
  int rank = item_rank(it) == 2 ? 2 : 1;
  if (!it->doc) return true;
  if (!read_numbers(t, it, rank, &read)) return false;
  if (rank == 1) read = (numbers){1, read.rows, read.data};
  if (read.columns != dim || (rank == 2 && read.rows != n)) {
    char room[64];
    complain(t, it, "is %s, needs an outward normal [%d] or one per point [%lld][%d]",
             doc_describe(it->doc, room, sizeof room), dim, (long long)n, dim);
    return false;
  }
  if (!normals_are_nonzero(t, it, dim, &read)) return false;
  *normals = read;
  return true;
}

static bool unknown_group(task *t, const item *at, const cloud_input *c, const char *name) {
  char room[SHOWN_MAX], list[256] = "";
  size_t used = 0;
  for (int64_t k = 0; k < c->groups && used < sizeof list; k++) {
    char each[SHOWN_MAX];
    used += (size_t)snprintf(list + used, sizeof list - used, "%s%s", k ? ", " : "",
                             shown(c->group[k].name, each));
  }
  complain(t, at, "there is no group \"%s\"; the cloud has %s", shown(name, room),
           c->groups ? list : "none");
  return false;
}

static bool read_group_normals(task *t, const item *it, cloud_input *c) {
  if (!it->doc) return true;
  if (!read_object(t, it, NULL)) return false;
  bool good = true;
  for (const doc *m = it->doc->child; m; m = m->next) {
    item member = {.doc = m, .up = it, .key = m->key};
    point_group *group = find_group(c, m->key);
    good &= group ? read_normals(t, &member, group->n, c->cloud.dim, &group->normals)
                  : unknown_group(t, &member, c, m->key);
  }
  return good;
}

static bool read_posted(task *t, const item *it, cloud_input *c) {
  static const char *const members[] = {"points", "spacing", "groups", "normals", NULL};
  item points = item_member(it, "points"), spacing = item_member(it, "spacing");
  item groups = item_member(it, "groups"), normals = item_member(it, "normals");
  bool known = read_object(t, it, members);
  item_pointer(&points, c->pointer);
  bool sized = read_number(t, &spacing, &range_positive, &c->spacing);
  if (!read_points(t, &points, c)) return false;
  bool grouped = read_groups(t, &groups, c);
  bool directed = read_group_normals(t, &normals, c);
  return known && sized && grouped && directed;
}

/* Lattices */

/* Reads [d] numbers; d = 0: 1 to 3 of them, which sets d. */
static bool read_corner(task *t, const item *it, int *dim, double *corner) {
  numbers array = {0};
  if (!read_required(t, it) || !read_numbers(t, it, 1, &array)) return false;
  bool fits = *dim ? array.rows == *dim : array.rows >= 1 && array.rows <= SCT_DIM_MAX;
  if (!fits) {
    char needed[8] = "1 to 3";
    if (*dim) snprintf(needed, sizeof needed, "%d", *dim);
    complain(t, it, "has %lld numbers, needs %s", (long long)array.rows, needed);
    return false;
  }
  *dim = (int)array.rows;
  memcpy(corner, array.data, (size_t)array.rows * sizeof *corner);
  return true;
}

static bool read_cells(task *t, const item *it, int *dim, int64_t *cells) {
  double values[SCT_DIM_MAX];
  numbers checked;
  if (!read_corner(t, it, dim, values)) return false;
  if (!read_integers(t, it, 1, SCT_POINTS_MAX - 1, &checked)) return false;
  for (int a = 0; a < *dim; a++) cells[a] = (int64_t)values[a];
  return true;
}

static bool box_is_open(task *t, const item *upper, const sct_lattice *lattice) {
  bool good = true;
  for (int a = 0; a < lattice->dim; a++) {
    double low = lattice->lower[a], high = lattice->upper[a];
    if (high > low && isfinite(high - low)) continue;
    item entry = item_element(upper, NULL, a);
    complain(t, &entry, "is %.15g, needs a number above lower, %.15g", high, low);
    good = false;
  }
  return good;
}

static bool lattice_is_small(task *t, const item *cells, const sct_lattice *lattice) {
  double points = 1;
  for (int a = 0; a < lattice->dim; a++) points *= (double)lattice->cells[a] + 1;
  if (points <= (double)t->limits->points) return true;
  complain(t, cells, "make %.15g points, at most %lld are allowed", points,
           (long long)t->limits->points);
  return false;
}

static bool make_points(task *t, cloud_input *c) {
  if (sct_lattice_check(&c->lattice, &t->error)) return false;
  c->cloud.dim = c->lattice.dim;
  c->cloud.n = sct_lattice_count(&c->lattice);
  c->spacing = sct_lattice_spacing(&c->lattice);
  double *x = task_take(t, c->cloud.n * c->cloud.dim, sizeof *x);
  if (!x) return false;
  sct_lattice_points(&c->lattice, x);
  c->posted = x;
  return true;
}

static bool read_lattice(task *t, const item *it, cloud_input *c) {
  static const char *const members[] = {"lower", "upper", "cells", "jitter", "seed", NULL};
  static const range jitters = {0, 1, false, true};
  const int64_t seeds = INT64_C(1) << 53; /* every integer below is exact in a double */
  item lower = item_member(it, "lower"), upper = item_member(it, "upper");
  item cells = item_member(it, "cells"), jitter = item_member(it, "jitter");
  item seed = item_member(it, "seed");
  sct_lattice *l = &c->lattice;
  int64_t chosen = 0;
  if (it->doc->kind != DOC_OBJECT) return read_object(t, it, members);
  bool good = read_object(t, it, members);
  good &= read_number(t, &jitter, &jitters, &l->jitter);
  good &= read_integer(t, &seed, 0, seeds - 1, &chosen);
  good &= read_corner(t, &lower, &l->dim, l->lower);
  bool boxed = read_corner(t, &upper, &l->dim, l->upper) && good;
  good &= boxed && box_is_open(t, &upper, l);
  good &= read_cells(t, &cells, &l->dim, l->cells) && lattice_is_small(t, &cells, l);
  l->seed = (uint64_t)chosen;
  return good && make_points(t, c);
}

/* A side of the lattice as a group of ours. */
static bool copy_side(task *t, const sct_group *side, int dim, point_group *group) {
  int32_t *index = task_take(t, side->n, sizeof *index);
  double *normal = task_take(t, side->normals * dim, sizeof *normal);
  if (!index || !normal) return false;
  if (side->n) memcpy(index, side->index, (size_t)side->n * sizeof *index);
  if (side->normals) memcpy(normal, side->normal, (size_t)(side->normals * dim) * sizeof *normal);
  *group = (point_group){side->name, side->n, index, {side->normals, dim, normal}};
  return true;
}

static bool lattice_group(task *t, const item *at, const cloud_input *c, const char *name,
                          point_group *group) {
  sct_side side = sct_side_find(name);
  char room[SHOWN_MAX];
  sct_group found = {0};
  sct_error error = {0};
  if (side == SCT_SIDE_COUNT || sct_lattice_group(&c->lattice, side, &found, &error)) {
    if (error.code == SCT_E_MEMORY) {
      t->error = error;
    } else {
      complain(t, at, "a lattice in %d-D has no group \"%s\"", c->cloud.dim, shown(name, room));
    }
    return false;
  }
  bool copied = copy_side(t, &found, c->cloud.dim, group);
  sct_group_clear(&found);
  return copied;
}

/* Numbering */

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
  item lattice = item_member(it, "lattice"), href = item_member(it, "href");
  if (href.doc) {
    complain(t, &href, "data by reference cannot be used here, needs points or a lattice");
    return false;
  }
  if (lattice.doc) {
    c->is_lattice = true;
    item_pointer(&lattice, c->pointer);
    return read_object(t, it, lattice_form) & read_lattice(t, &lattice, c);
  }
  if (doc_member(it->doc, "points")) return read_posted(t, it, c);
  if (read_object(t, it, forms)) complain(t, it, "has no points, needs points or a lattice");
  return false;
}

bool cloud_input_read(task *t, const item *it, cloud_input *c) {
  *c = (cloud_input){0};
  if (!read_required(t, it)) return false;
  if (it->doc->kind != DOC_OBJECT) return read_object(t, it, NULL);
  return read_either(t, it, c) && number_points(t, c);
}

/* Questions */

bool cloud_input_group(task *t, const item *at, const cloud_input *c, const char *name,
                       point_group *group) {
  if (c->is_lattice) return lattice_group(t, at, c, name, group);
  const point_group *found = find_group(c, name);
  if (!found) return unknown_group(t, at, c, name);
  *group = *found;
  return true;
}

static void mark(const cloud_input *c, const point_group *group, uint8_t value, uint8_t *mask) {
  for (int64_t k = 0; k < group->n; k++) mask[c->place[group->index[k]]] = value;
}

uint8_t *cloud_input_interior(task *t, const cloud_input *c) {
  uint8_t *mask = task_take(t, c->cloud.n, 1);
  if (!mask) return NULL;
  memset(mask, 1, (size_t)c->cloud.n);
  if (c->is_lattice) {
    point_group boundary;
    if (!lattice_group(t, NULL, c, sct_side_name(SCT_SIDE_BOUNDARY), &boundary)) return NULL;
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
