#include "field_input.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

sites sites_all(const cloud_input *c) {
  return (sites){c, c->cloud.n, c->order, NULL};
}

/* Expressions */

/* "point 17 at (0.5, 0.25)" of site k. */
static void name_site(const sites *on, int64_t k, char *room, size_t size) {
  int dim = on->cloud->cloud.dim;
  const double *x = on->cloud->posted + (int64_t)on->client[k] * dim;
  int used = snprintf(room, size, "point %d at (", on->client[k]);
  for (int a = 0; a < dim; a++) {
    used += snprintf(room + used, size - (size_t)used, "%s%.6g", a ? ", " : "", x[a]);
  }
  snprintf(room + used, size - (size_t)used, ")");
}

/* Complains of the first value of component `a` that is not finite. */
static bool component_is_finite(task *t, const field *f, int a) {
  char where[128];
  int64_t first = -1, others = 0;
  for (int64_t k = 0; k < f->on.n; k++) {
    if (isfinite(f->value[k * f->components + a])) continue;
    if (first >= 0) others++;
    if (first < 0) first = k;
  }
  if (first < 0) return true;
  const double value = f->value[first * f->components + a];
  name_site(&f->on, first, where, sizeof where);
  char more[64] = "";
  if (others > 0) snprintf(more, sizeof more, " and not finite at %lld more", (long long)others);
  problem_add(&t->complaints, f->pointer[a], "is %g at %s%s, needs a finite number",
              isnan(value) ? NAN : value, where, more); /* the sign of a NaN says nothing */
  return false;
}

static bool evaluate(task *t, field *f, int a, double time) {
  const cloud_input *c = f->on.cloud;
  language *l = language_of(t);
  if (!l) return false;
  if (!expression_evaluate(l, &f->component[a], c->cloud.dim, c->cloud.x, f->on.place, f->on.n,
                           time, f->value + a, f->components)) {
    (void)sct_fail(&t->error, SCT_E_MEMORY, -1, "no room for the data of the request");
    return false;
  }
  return component_is_finite(t, f, a);
}

static const char *keep_pointer(task *t, const item *it) {
  char pointer[PROBLEM_POINTER];
  item_pointer(it, pointer);
  const size_t size = strlen(pointer) + 1;
  char *copy = task_take(t, (int64_t)size, 1);
  return copy ? memcpy(copy, pointer, size) : NULL;
}

static bool is_affordable(task *t, const item *it, const expression *e, int64_t points) {
  const int64_t most = t->limits->expression_work;
  if (e->operations <= most / (points > 0 ? points : 1)) return true;
  complain(t, it,
           "has %lld operations, for %lld points, which are more than %lld together "
           "(expression-work)",
           (long long)e->operations, (long long)points, (long long)most);
  return false;
}

static bool read_expression(task *t, const item *it, const sites *on, expression *e) {
  const char *text = NULL;
  char room[SHOWN_MAX];
  expression_error why;
  if (!read_text(t, it, &text)) return false;
  if (it->doc->length > (size_t)t->limits->expression_bytes) {
    complain(t, it, "has %zu characters, at most %lld are allowed", it->doc->length,
             (long long)t->limits->expression_bytes);
    return false;
  }
  language *l = language_of(t);
  if (!l) return false;
  if (expression_check(l, text, on ? on->cloud->cloud.dim : SCT_DIM_MAX, e, &why)) {
    return is_affordable(t, it, e, on ? on->n : 1);
  }
  complain(t, it, "expression \"%s\": %s, at position %lld", shown(text, room), why.text,
           (long long)why.position);
  return false;
}

/* Component a of a field from the text of an expression. */
static bool take_expression(task *t, const item *it, double time, int a, field *f) {
  const sites *on = f->on.cloud ? &f->on : NULL;
  if (!read_expression(t, it, on, &f->component[a])) return false;
  if (!on) return true;
  f->pointer[a] = keep_pointer(t, it);
  f->varies |= f->component[a].varies;
  return f->pointer[a] && evaluate(t, f, a, time);
}

/* Numbers */

static void fill(field *f, int a, double value) {
  if (!f->value) return;
  for (int64_t k = 0; k < f->on.n; k++) f->value[k * f->components + a] = value;
}

static bool take_number(task *t, const item *it, int a, field *f) {
  double value = 0;
  if (!read_number(t, it, &range_any, &value)) return false;
  fill(f, a, value);
  return true;
}

/* Rows of numbers, one per site or, where the sites are only some points, one per point. */
static bool take_rows(task *t, const item *it, int rank, field *f) {
  numbers rows = {0};
  if (!read_numbers(t, it, rank, &rows)) return false;
  const sites *on = &f->on;
  if (!on->cloud) return true;
  bool by_site = on->place && rows.rows == on->n, by_point = rows.rows == on->cloud->cloud.n;
  if (!(by_site || by_point) || rows.columns != f->components) {
    char room[64];
    complain(t, it, "is %s, needs %d number%s for each of %lld points",
             doc_describe(it->doc, room, sizeof room), f->components, f->components > 1 ? "s" : "",
             (long long)on->n);
    return false;
  }
  for (int64_t k = 0; k < on->n; k++) {
    const double *from = rows.data + (by_site ? k : on->client[k]) * f->components;
    for (int a = 0; a < f->components; a++) f->value[k * f->components + a] = from[a];
  }
  return true;
}

/* Fields */

static bool begin(task *t, const sites *on, int components, field *f) {
  *f = (field){.components = components};
  if (!on) return true;
  f->on = *on;
  f->value = task_take(t, on->n * components, sizeof *f->value);
  return f->value != NULL;
}

static bool refuse(task *t, const item *it, const char *needed) {
  char room[64];
  complain(t, it, "is %s, needs %s", doc_describe(it->doc, room, sizeof room), needed);
  return false;
}

bool read_scalar_field(task *t, const item *it, const sites *on, double time, field *f) {
  *f = (field){0};
  if (!it->doc) return true;
  if (!begin(t, on, 1, f)) return false;
  if (it->doc->kind == DOC_NUMBER) return take_number(t, it, 0, f);
  if (it->doc->kind == DOC_TEXT) return take_expression(t, it, time, 0, f);
  if (item_rank(it)) return take_rows(t, it, 1, f);
  return refuse(t, it, "a number, an array of numbers or an expression");
}

static bool take_component(task *t, const item *it, double time, int a, field *f) {
  if (it->doc->kind == DOC_NUMBER) return take_number(t, it, a, f);
  if (it->doc->kind == DOC_TEXT) return take_expression(t, it, time, a, f);
  return refuse(t, it, "a number or an expression");
}

/* [dim], each a number or an expression. */
static bool take_components(task *t, const item *it, double time, field *f) {
  numbers array = {0};
  bool good = true;
  if (it->doc->kind == DOC_NUMBERS) {
    if (!read_numbers(t, it, 1, &array)) return false;
    for (int a = 0; a < array.rows; a++) fill(f, a, array.data[a]);
    return true;
  }
  int64_t a = 0;
  for (const doc *d = it->doc->child; d; d = d->next, a++) {
    item element = item_element(it, d, a);
    good &= take_component(t, &element, time, (int)a, f);
  }
  return good;
}

static bool is_by_point(const doc *d) {
  if (d->kind == DOC_NUMBERS) return d->rank == 2;
  bool has_row = d->child && d->child->kind != DOC_NUMBER && d->child->kind != DOC_TEXT;
  return d->kind == DOC_LIST && has_row;
}

bool read_vector_field(task *t, const item *it, const sites *on, double time, field *f) {
  *f = (field){0};
  if (!it->doc) return true;
  if (it->doc->kind != DOC_NUMBERS && it->doc->kind != DOC_LIST) {
    return refuse(t, it, "an array of numbers or expressions, or an array of vectors");
  }
  bool by_point = is_by_point(it->doc);
  int64_t length = it->doc->kind == DOC_NUMBERS ? it->doc->shape[0] : it->doc->count;
  int dim = on ? on->cloud->cloud.dim : length > SCT_DIM_MAX ? SCT_DIM_MAX : (int)length;
  if (!begin(t, on, dim, f)) return false;
  if (by_point) return take_rows(t, it, 2, f);
  if (length == dim) return take_components(t, it, time, f);
  complain(t, it, "has %lld components, needs %d", (long long)length, dim);
  return false;
}

bool field_advance(task *t, field *f, double time) {
  for (int a = 0; a < f->components; a++) {
    if (f->component[a].varies && !evaluate(t, f, a, time)) return false;
  }
  return true;
}
