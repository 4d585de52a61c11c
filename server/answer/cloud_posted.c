/* cloud_posted.c - {"points":.., "spacing":.., "groups":.., "normals":..} */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "cloud_kind.h"

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

bool cloud_posted_read(task *t, const item *it, cloud_input *c) {
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

bool cloud_posted_group(task *t, const item *at, const cloud_input *c, const char *name,
                        point_group *group) {
  const point_group *found = find_group(c, name);
  if (!found) return unknown_group(t, at, c, name);
  *group = *found;
  return true;
}
