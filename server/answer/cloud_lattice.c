/* cloud_lattice.c - {"lattice": {"lower":.., "upper":.., "cells":.., "jitter":.., "seed":..}} */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "cloud_kind.h"

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
  static const double longest = 1e290; /* times a number of cells it is finite */
  bool good = true;
  for (int a = 0; a < lattice->dim; a++) {
    double low = lattice->lower[a], high = lattice->upper[a];
    if (high > low && high - low <= longest) continue;
    item entry = item_element(upper, NULL, a);
    if (high > low) {
      complain(t, &entry, "is %.15g, needs at most %g above lower, %.15g", high, longest, low);
    } else {
      complain(t, &entry, "is %.15g, needs a number above lower, %.15g", high, low);
    }
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

bool cloud_lattice_read(task *t, const item *it, cloud_input *c) {
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

/* Makes the group of a side; false with a complaint where the dimension has no such side. */
static bool make_side(task *t, const item *at, cloud_input *c, const char *name, sct_side side) {
  sct_group found = {0};
  sct_error error = {0};
  char room[SHOWN_MAX];
  sct_status status = side == SCT_SIDE_COUNT ? SCT_E_ARGUMENT
                                             : sct_lattice_group(&c->lattice, side, &found, &error);
  if (status == SCT_E_ARGUMENT) {
    static const char *const sides[] = {"", "left, right", "left, right, bottom, top",
                                        "left, right, bottom, top, back, front"};
    complain(t, at, "a lattice in %d-D has no group \"%s\", needs %s, boundary or interior",
             c->cloud.dim, shown(name, room), sides[c->cloud.dim]);
  } else if (status) {
    t->error = error;
  }
  if (status) return false;
  bool copied = copy_side(t, &found, c->cloud.dim, &c->side[side]);
  sct_group_clear(&found);
  return copied;
}

bool cloud_lattice_group(task *t, const item *at, cloud_input *c, const char *name,
                         point_group *group) {
  sct_side side = sct_side_find(name);
  bool is_made = side != SCT_SIDE_COUNT && c->side[side].name;
  if (!is_made && !make_side(t, at, c, name, side)) return false;
  *group = c->side[side];
  return true;
}
