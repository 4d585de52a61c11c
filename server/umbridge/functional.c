#include "functional.h"

#include <math.h>

struct functional_kind {
  const char *name;
  bool is_each; /* a number for each point, not one for all */
  /* dq/dphi_i of each of the n points, weight [n] */
  void (*weigh)(const functional *f, const double *phi, double *weight);
};

/* Kinds */

static void weigh_value(const functional *f, const double *phi, double *weight) {
  (void)phi;
  for (int64_t k = 0; k < f->n; k++) weight[k] = 1;
}

static void weigh_mean(const functional *f, const double *phi, double *weight) {
  (void)phi;
  for (int64_t k = 0; k < f->n; k++) weight[k] = 1 / (double)f->n;
}

static double sign(double value) {
  return (value > 0) - (value < 0);
}

static void weigh_l1(const functional *f, const double *phi, double *weight) {
  for (int64_t k = 0; k < f->n; k++) weight[k] = sign(phi[f->place[k]]) / (double)f->n;
}

static void weigh_l2(const functional *f, const double *phi, double *weight) {
  double sum = 0;
  for (int64_t k = 0; k < f->n; k++) sum += phi[f->place[k]] * phi[f->place[k]];
  const double norm = sqrt(sum / (double)f->n);
  for (int64_t k = 0; k < f->n; k++) {
    weight[k] = norm > 0 ? phi[f->place[k]] / ((double)f->n * norm) : 0;
  }
}

static void weigh_linf(const functional *f, const double *phi, double *weight) {
  int64_t at = 0;
  for (int64_t k = 0; k < f->n; k++) {
    weight[k] = 0;
    if (fabs(phi[f->place[k]]) > fabs(phi[f->place[at]])) at = k;
  }
  weight[at] = sign(phi[f->place[at]]);
}

static const functional_kind kinds[] = {{"values", true, weigh_value},
                                        {"mean", false, weigh_mean},
                                        {"l1", false, weigh_l1},
                                        {"l2", false, weigh_l2},
                                        {"linf", false, weigh_linf}};
static const char *const kind_names[] = {"values", "mean", "l1", "l2", "linf", NULL};

/* Reading */

static bool take_points(task *t, const item *it, cloud_input *c, functional *f) {
  point_group group = {.n = c->cloud.n};
  if (it->doc && !read_points(t, it, c, &group)) return false;
  int32_t *place = task_take(t, group.n, sizeof *place);
  if (!place) return false;
  for (int64_t k = 0; k < group.n; k++)
    place[k] = group.index ? c->place[group.index[k]] : c->place[k];
  f->n = group.n;
  f->place = place;
  if (group.n > 0) return true;
  complain(t, it, "names no point, needs one or more");
  return false;
}

static bool take_places(task *t, const item *at, const cloud_input *c, functional *f) {
  if (!read_numbers(t, at, 2, &f->at)) return false;
  if (f->at.rows > 0 && f->at.columns == c->cloud.dim) return true;
  complain(t, at, "is %lld places of %lld coordinates, needs one or more of %d",
           (long long)f->at.rows, (long long)f->at.columns, c->cloud.dim);
  return false;
}

/* Which points or places, once the kind is known. */
static bool read_where(task *t, const item *on, const item *at, cloud_input *c, functional *f) {
  if (!at->doc) {
    if (!take_points(t, on, c, f)) return false;
    f->size = f->kind->is_each ? f->n : 1;
    return true;
  }
  if (!f->kind->is_each || on->doc) {
    complain(t, at, "stands beside %s, needs type values alone", on->doc ? "on" : f->kind->name);
    return false;
  }
  if (!take_places(t, at, c, f)) return false;
  f->size = f->at.rows;
  return true;
}

bool functional_read(task *t, const item *it, cloud_input *c, functional *f) {
  static const char *const members[] = {"type", "on", "at", NULL};
  const bool is_name = it->doc->kind == DOC_TEXT;
  const item none = {.up = it, .key = ""};
  const item type = is_name ? *it : item_member(it, "type");
  const item on = is_name ? none : item_member(it, "on"),
             at = is_name ? none : item_member(it, "at");
  int chosen = 0;
  *f = (functional){0};
  item_pointer(it, f->pointer);
  if (!is_name && !read_object(t, it, members)) return false;
  if (!read_choice(t, &type, kind_names, &chosen)) return false;
  f->kind = &kinds[chosen];
  return read_where(t, &on, &at, c, f);
}

/* Rows */

static bool rows_at_points(task *t, const functional *f, const double *phi, sct_csr *rows) {
  (void)t;
  f->kind->weigh(f, phi, rows->value);
  for (int64_t k = 0; k < f->n; k++) {
    rows->column[k] = f->place[k];
    rows->start[f->kind->is_each ? k + 1 : 1] = k + 1;
  }
  return true;
}

static int64_t nearest(const sct_cloud *cloud, const double *x, double *distance) {
  int64_t found = 0;
  double least = INFINITY;
  for (int64_t i = 0; i < cloud->n; i++) {
    double square = 0;
    for (int a = 0; a < cloud->dim; a++) {
      square += (cloud->x[i * cloud->dim + a] - x[a]) * (cloud->x[i * cloud->dim + a] - x[a]);
    }
    if (square < least) found = i;
    least = fmin(least, square);
  }
  *distance = sqrt(least);
  return found;
}

/* phi_i + sum_j (g_ij . (x - x_i)) (phi_j - phi_i) as a row behind those there are. */
static void interpolate(const sct_cloud *cloud, const sct_row *row, int64_t i, const double *x,
                        sct_csr *rows, int64_t r) {
  int64_t end = rows->start[r];
  double own = 1;
  for (int64_t k = 0; k < row->n; k++, end++) {
    double weight = 0;
    for (int a = 0; a < cloud->dim; a++) {
      weight += row->gradient[a * row->n + k] * (x[a] - cloud->x[i * cloud->dim + a]);
    }
    rows->column[end] = row->index[k];
    rows->value[end] = weight;
    own -= weight;
  }
  rows->column[end] = (int32_t)i;
  rows->value[end] = own;
  rows->start[r + 1] = end + 1;
}

static bool row_at_place(task *t, const functional *f, const solve *s, int64_t r, sct_room *room,
                         sct_csr *rows) {
  const sct_cloud *cloud = &s->in.cloud.cloud;
  const double *x = f->at.data + r * cloud->dim;
  double distance;
  const int64_t i = nearest(cloud, x, &distance);
  if (distance > 2 * s->grid.spacing) {
    problem_add(&t->complaints, f->pointer,
                "place %lld is %.6g from the nearest point, needs a place within the cloud",
                (long long)r, distance);
    return false;
  }
  const sct_row_request request = {.want = SCT_ROW_GRADIENT};
  sct_row row;
  if (sct_stencil_row(s->grid.stencil, i, &request, room, &row, &t->error)) return false;
  interpolate(cloud, &row, i, x, rows, r);
  return true;
}

static bool rows_at_places(task *t, const functional *f, const solve *s, sct_csr *rows) {
  sct_room *room = NULL;
  bool good = !sct_room_new(s->grid.stencil, &room, &t->error);
  for (int64_t r = 0; good && r < f->size; r++) good = row_at_place(t, f, s, r, room, rows);
  sct_room_free(&room);
  return good;
}

/* Entries at most: an interpolated place needs its neighbours, and itself. */
static int64_t entries_of(const task *t, const functional *f) {
  return f->at.data ? f->size * (t->limits->neighbours + 1) : f->n;
}

bool functional_rows(task *t, const functional *f, const solve *s, sct_csr **rows) {
  if (sct_csr_new(f->size, s->in.cloud.cloud.n, entries_of(t, f), rows, &t->error)) return false;
  if (f->at.data ? rows_at_places(t, f, s, *rows) : rows_at_points(t, f, s->phi, *rows))
    return true;
  sct_csr_free(rows);
  return false;
}
