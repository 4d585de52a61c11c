#include "boundary_input.h"

#include <stdlib.h>
#include <string.h>

static const char *const members[] = {"on", "type", "value", "normal", "coefficient", NULL};

/* In the order of sct_condition, from SCT_DIRICHLET on. */
static const char *const types[] = {"dirichlet", "neumann", "robin", NULL};

/* The points */

static bool read_indices(task *t, const item *it, const cloud_input *c, point_group *group) {
  numbers index = {0};
  int64_t last = c ? c->cloud.n - 1 : SCT_POINTS_MAX;
  if (!read_integers(t, it, 0, last, &index)) return false;
  int32_t *copy = task_take(t, index.rows, sizeof *copy);
  if (!copy) return false;
  for (int64_t k = 0; k < index.rows; k++) copy[k] = (int32_t)index.data[k];
  *group = (point_group){.n = index.rows, .index = copy};
  return true;
}

bool read_points(task *t, const item *it, cloud_input *c, point_group *group) {
  const char *name = NULL;
  if (!read_required(t, it)) return false;
  if (it->doc->kind != DOC_TEXT && !item_rank(it)) {
    complain(t, it, "needs the name of a group or an array of point numbers");
    return false;
  }
  if (it->doc->kind != DOC_TEXT) return read_indices(t, it, c, group);
  if (!read_text(t, it, &name)) return false;
  return !c || cloud_input_group(t, it, c, name, group);
}

static bool place_points(task *t, const cloud_input *c, const point_group *group, sites *on) {
  int32_t *place = task_take(t, group->n, sizeof *place);
  if (!place) return false;
  for (int64_t k = 0; k < group->n; k++) place[k] = c->place[group->index[k]];
  *on = (sites){c, group->n, group->index, place};
  return true;
}

/* Normals */

static int by_number(const void *a, const void *b) {
  return *(const int32_t *)a - *(const int32_t *)b;
}

/* Normals of listed points of a lattice: those of its group `boundary`, if they are all in it. */
static bool lattice_normals(task *t, const item *it, cloud_input *c, const point_group *points,
                            numbers *normals) {
  const int dim = c->cloud.dim;
  point_group boundary;
  if (!c->is_lattice || points->name) return true;
  if (!cloud_input_group(t, it, c, sct_side_name(SCT_SIDE_BOUNDARY), &boundary)) return false;
  double *normal = task_take(t, points->n * dim, sizeof *normal);
  if (!normal) return false;
  for (int64_t k = 0; k < points->n; k++) {
    const int32_t *found = bsearch(&points->index[k], boundary.index, (size_t)boundary.n,
                                   sizeof *boundary.index, by_number);
    if (!found) return true;
    const double *from = boundary.normals.data + (found - boundary.index) * dim;
    memcpy(normal + k * dim, from, (size_t)dim * sizeof *normal);
  }
  *normals = (numbers){points->n, dim, normal};
  return true;
}

static bool read_entry_normals(task *t, const item *it, cloud_input *c, const point_group *points,
                               boundary_entry *entry) {
  item normal = item_member(it, "normal");
  entry->normals = points->normals;
  if (!read_normals(t, &normal, points->n, c->cloud.dim, &entry->normals)) return false;
  if (entry->type == SCT_DIRICHLET) return true;
  if (!entry->normals.rows && !lattice_normals(t, it, c, points, &entry->normals)) return false;
  if (entry->normals.rows || points->n == 0) return true;
  complain(t, &normal, "is missing and required: %s needs an outward normal, and %s%s has none",
           types[entry->type - SCT_DIRICHLET], points->name ? "group " : "a list of points",
           points->name ? points->name : "");
  return false;
}

/* Entries */

static bool read_coefficient(task *t, const item *it, const sites *on, double time,
                             boundary_entry *entry) {
  item coefficient = item_member(it, "coefficient");
  if (entry->type == SCT_ROBIN && !coefficient.doc) {
    complain(t, &coefficient, "is missing and required: robin is coefficient phi + d phi/dn");
    return false;
  }
  if (entry->type != SCT_ROBIN && coefficient.doc) { /* whoever sends it expects that it counts */
    complain(t, &coefficient, "is of robin conditions only, needs to be left out with %s",
             types[entry->type - SCT_DIRICHLET]);
    return false;
  }
  return read_scalar_field(t, &coefficient, on, time, &entry->coefficient);
}

static bool read_entry(task *t, const item *it, cloud_input *c, double time,
                       boundary_entry *entry) {
  item type = item_member(it, "type"), on = item_member(it, "on"), value = item_member(it, "value");
  point_group points = {0};
  int chosen = 0;
  if (!read_object(t, it, members) && it->doc->kind != DOC_OBJECT) return false;
  bool typed = read_required(t, &type) && read_choice(t, &type, types, &chosen);
  entry->type = (sct_condition)(SCT_DIRICHLET + chosen);
  bool placed = read_points(t, &on, c, &points) && c && place_points(t, c, &points, &entry->on);
  const sites *where = placed ? &entry->on : NULL;
  bool good = typed && (placed || !c);
  good &= read_required(t, &value) && read_scalar_field(t, &value, where, time, &entry->value);
  good &= !typed || read_coefficient(t, it, where, time, entry);
  if (placed && typed) good &= read_entry_normals(t, it, c, &points, entry);
  return good;
}

static bool read_entries(task *t, const item *it, cloud_input *c, double time, boundary_input *b) {
  bool good = true;
  b->entry = task_zeros(t, it->doc->count, sizeof *b->entry);
  if (!b->entry) return false;
  for (const doc *d = it->doc->child; d; d = d->next) {
    item entry = item_element(it, d, b->entries);
    item_unwrap(&entry);
    good &= read_entry(t, &entry, c, time, &b->entry[b->entries++]);
  }
  return good;
}

/* Arrays by place */

static bool take_arrays(task *t, const cloud_input *c, boundary_input *b) {
  int64_t n = c->cloud.n;
  b->condition = task_zeros(t, n, sizeof *b->condition);
  b->value = task_zeros(t, n, sizeof *b->value);
  b->coefficient = task_zeros(t, n, sizeof *b->coefficient);
  b->normal = task_zeros(t, n * c->cloud.dim, sizeof *b->normal);
  b->owner = task_take(t, n, sizeof *b->owner);
  if (!b->condition || !b->value || !b->coefficient || !b->normal || !b->owner) return false;
  memset(b->owner, -1, (size_t)n * sizeof *b->owner);
  return true;
}

static void claim_points(boundary_input *b, int64_t e) {
  const boundary_entry *entry = &b->entry[e];
  for (int64_t k = 0; k < entry->on.n; k++) {
    b->owner[entry->on.place[k]] = (int32_t)e;
    b->condition[entry->on.place[k]] = (uint8_t)entry->type;
  }
}

static void copy_values(boundary_input *b, int64_t e) {
  const boundary_entry *entry = &b->entry[e];
  for (int64_t k = 0; k < entry->on.n; k++) {
    int32_t i = entry->on.place[k];
    if (b->owner[i] != e) continue;
    b->value[i] = entry->value.value[k];
    if (entry->coefficient.value) b->coefficient[i] = entry->coefficient.value[k];
  }
}

static void copy_normals(boundary_input *b, int64_t e, int dim) {
  const boundary_entry *entry = &b->entry[e];
  if (!entry->normals.rows) return;
  for (int64_t k = 0; k < entry->on.n; k++) {
    int32_t i = entry->on.place[k];
    const double *from = entry->normals.data + (entry->normals.rows > 1 ? k * dim : 0);
    if (b->owner[i] == e) memcpy(b->normal + (int64_t)i * dim, from, (size_t)dim * sizeof *from);
  }
}

static bool spread(task *t, const cloud_input *c, boundary_input *b) {
  if (!take_arrays(t, c, b)) return false;
  for (int64_t e = 0; e < b->entries; e++) claim_points(b, e);
  for (int64_t e = 0; e < b->entries; e++) {
    copy_values(b, e);
    copy_normals(b, e, c->cloud.dim);
    b->varies |= b->entry[e].value.varies;
    b->matrix_varies |= b->entry[e].type == SCT_ROBIN && b->entry[e].coefficient.varies;
  }
  for (int64_t i = 0; i < c->cloud.n; i++) b->constrained += b->condition[i] == SCT_DIRICHLET;
  return true;
}

bool boundary_input_read(task *t, const item *it, cloud_input *c, double time, boundary_input *b) {
  *b = (boundary_input){0};
  bool is_empty = !it->doc || (it->doc->kind == DOC_NUMBERS && it->doc->count == 0);
  if (!is_empty && it->doc->kind != DOC_LIST) {
    char room[64];
    complain(t, it, "is %s, needs an array of conditions",
             doc_describe(it->doc, room, sizeof room));
    return false;
  }
  if (!is_empty && !read_entries(t, it, c, time, b)) return false;
  return !c || spread(t, c, b);
}

bool boundary_input_advance(task *t, boundary_input *b, double time) {
  for (int64_t e = 0; e < b->entries; e++) {
    boundary_entry *entry = &b->entry[e];
    if (!entry->value.varies && !entry->coefficient.varies) continue;
    if (!field_advance(t, &entry->value, time)) return false;
    if (!field_advance(t, &entry->coefficient, time)) return false;
    copy_values(b, e);
  }
  return true;
}
