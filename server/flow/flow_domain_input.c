#include "flow_domain_input.h"

#include <math.h>
#include <stdlib.h>

#include "scatter/flow_case.h"

/* ---- fields ---- */

static bool read_expression(task *t, const item *it, expression *e) {
  const char *text = NULL;
  char room[SHOWN_MAX];
  expression_error why;
  language *l = language_of(t);
  if (!l || !read_text(t, it, &text)) return false;
  if (it->doc->length > (size_t)t->limits->expression_bytes) {
    complain(t, it, "has %zu characters, at most %lld are allowed", it->doc->length,
             (long long)t->limits->expression_bytes);
    return false;
  }
  if (expression_check(l, text, 2, e, &why)) return true;
  complain(t, it, "expression \"%s\": %s, at position %lld", shown(text, room), why.text,
           (long long)why.position);
  return false;
}

static bool read_component(task *t, const item *it, int a, flow_field *f) {
  char room[64];
  if (it->doc->kind == DOC_NUMBER) return read_number(t, it, &range_any, &f->number[a]);
  if (it->doc->kind == DOC_TEXT) return read_expression(t, it, &f->text[a]);
  complain(t, it, "is %s, needs a number or an expression",
           doc_describe(it->doc, room, sizeof room));
  return false;
}

bool flow_field_read_scalar(task *t, const item *it, flow_field *f) {
  *f = (flow_field){.t = t, .components = 1};
  return !it->doc || read_component(t, it, 0, f);
}

bool flow_field_read_vector(task *t, const item *it, flow_field *f) {
  numbers two = {0};
  char room[64];
  bool good = true;
  *f = (flow_field){.t = t, .components = 2};
  if (!it->doc) return true;
  if (it->doc->kind == DOC_NUMBERS && it->doc->rank == 1 && it->doc->count == 2) {
    if (!read_numbers(t, it, 1, &two)) return false;
    for (int a = 0; a < 2; a++) f->number[a] = two.data[a];
    return true;
  }
  if (it->doc->kind != DOC_LIST || it->doc->count != 2) {
    complain(t, it, "is %s, needs two numbers or expressions",
             doc_describe(it->doc, room, sizeof room));
    return false;
  }
  int a = 0;
  for (const doc *d = it->doc->child; d; d = d->next, a++) {
    item element = item_element(it, d, a);
    good &= read_component(t, &element, a, f);
  }
  return good;
}

sct_status flow_field_values(void *field, int64_t n, const double *x, double *value,
                             sct_error *err) {
  flow_field *f = field;
  for (int a = 0; a < f->components; a++) {
    if (!f->text[a].text) {
      for (int64_t k = 0; k < n; k++) value[k * f->components + a] = f->number[a];
    } else if (!expression_evaluate(f->t->language, &f->text[a], 2, x, NULL, n, 0, value + a,
                                    f->components)) {
      return sct_fail(err, SCT_E_MEMORY, -1, "no memory to evaluate an expression");
    }
  }
  return SCT_OK;
}

/* ---- boxes ---- */

static bool read_place(task *t, const item *it, double place[2]) {
  numbers two = {0};
  if (!read_required(t, it) || !read_numbers(t, it, 1, &two)) return false;
  if (two.rows != 2) {
    complain(t, it, "has %lld coordinates, needs 2", (long long)two.rows);
    return false;
  }
  for (int a = 0; a < 2; a++) place[a] = two.data[a];
  return true;
}

static bool read_box(task *t, const item *it, sct_flow_box *box) {
  static const char *const members[] = {"lower", "upper", NULL};
  item lower = item_member(it, "lower"), upper = item_member(it, "upper");
  if (!read_object(t, it, members)) return false;
  bool good = read_place(t, &lower, box->lower) & read_place(t, &upper, box->upper);
  for (int a = 0; a < 2 && good; a++) {
    if (box->lower[a] < box->upper[a]) continue;
    complain(t, &upper, "is %g in %c, needs more than lower, %g", box->upper[a], "xy"[a],
             box -> lower[a]);
    good = false;
  }
  return good;
}

/* A list of objects; *n and false with a complaint where it is none. */
static bool count_list(task *t, const item *it, int64_t *n) {
  char room[64];
  *n = 0;
  if (!it->doc || (it->doc->kind == DOC_NUMBERS && it->doc->count == 0)) return true;
  if (it->doc->kind == DOC_LIST) {
    *n = it->doc->count;
    return true;
  }
  complain(t, it, "is %s, needs a list of objects", doc_describe(it->doc, room, sizeof room));
  return false;
}

static bool read_boxes(task *t, const item *it, sct_flow_box **boxes, int64_t *n) {
  bool good = count_list(t, it, n);
  int64_t k = 0;
  *boxes = task_zeros(t, *n, sizeof **boxes);
  if (!good || !*boxes || *n == 0) return good && *boxes;
  for (const doc *d = it->doc->child; d; d = d->next, k++) {
    item element = item_element(it, d, k);
    good &= read_box(t, &element, &(*boxes)[k]);
  }
  return good;
}

/* ---- sides ---- */

static bool read_side(task *t, const item *it, sct_flow_side *s, flow_field *profile) {
  static const char *const members[] = {"type", "from", "to", "velocity", "scalar", NULL};
  const char *kinds[SCT_FLOW_SIDE_COUNT + 1] = {NULL};
  item type = item_member(it, "type"), velocity = item_member(it, "velocity");
  item from = item_member(it, "from"), to = item_member(it, "to"), c = item_member(it, "scalar");
  int kind = 0;
  for (int k = 0; k < SCT_FLOW_SIDE_COUNT; k++) kinds[k] = sct_flow_kind_name((sct_flow_kind)k);
  if (!read_object(t, it, members)) return false;
  bool good = read_required(t, &type) && read_choice(t, &type, kinds, &kind);
  good &= read_place(t, &from, s->from) & read_place(t, &to, s->to);
  good &= flow_field_read_vector(t, &velocity, profile);
  good &= read_number(t, &c, &range_any, &s->scalar);
  s->kind = (sct_flow_kind)kind;
  s->has_scalar = c.doc != NULL;
  s->profile = flow_field_values;
  s->context = profile;
  if (good && s->kind == SCT_FLOW_INFLOW && !velocity.doc) good = read_required(t, &velocity);
  if (good && s->kind == SCT_FLOW_OUTFLOW && velocity.doc) {
    complain(t, &velocity, "is of an outflow, which has none");
    good = false;
  }
  return good;
}

static bool read_sides(task *t, const item *it, flow_domain_input *d) {
  bool good = count_list(t, it, &d->domain.sides);
  int64_t k = 0;
  d->side = task_zeros(t, d->domain.sides, sizeof *d->side);
  d->profile = task_zeros(t, d->domain.sides, sizeof *d->profile);
  if (!d->side || !d->profile) return false;
  if (!good || d->domain.sides == 0) return good;
  for (const doc *one = it->doc->child; one; one = one->next, k++) {
    item element = item_element(it, one, k);
    good &= read_side(t, &element, &d->side[k], &d->profile[k]);
  }
  return good;
}

/* ---- lines ---- */

static int ascending(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Places along an axis that must be lines: sorted, each once; returns how many. */
static int64_t breaks(const flow_domain_input *d, int a, double *at) {
  const sct_flow_domain *m = &d->domain;
  int64_t n = 0, kept = 1;
  for (int64_t k = 0; k < m->fluids + m->solids; k++) {
    const sct_flow_box *b = k < m->fluids ? &d->fluid[k] : &d->solid[k - m->fluids];
    at[n++] = b->lower[a];
    at[n++] = b->upper[a];
  }
  for (int64_t k = 0; k < m->sides; k++) {
    at[n++] = d->side[k].from[a];
    at[n++] = d->side[k].to[a];
  }
  qsort(at, (size_t)n, sizeof *at, ascending);
  const double extent = at[n - 1] - at[0];
  for (int64_t k = 1; k < n; k++) {
    if (at[k] - at[kept - 1] > 1e-9 * extent) at[kept++] = at[k];
  }
  return kept;
}

/* Cells of a segment between two breaks. */
static double segment(const flow_domain_input *d, double length) {
  return fmax(2, round(length / d->spacing));
}

static bool lay_axis(task *t, const item *spacing, flow_domain_input *d, int a, double clustering) {
  const int64_t most = 2 * (d->domain.fluids + d->domain.solids + d->domain.sides);
  double *at = task_take(t, most, sizeof *at), cells = 0;
  if (!at) return false;
  const int64_t n = breaks(d, a, at);
  for (int64_t k = 0; k + 1 < n; k++) cells += segment(d, at[k + 1] - at[k]);
  if (!(cells <= (double)t->limits->points)) {
    complain(t, spacing, "is %g, which makes %.3g cells, at most %lld are allowed", d->spacing,
             cells, (long long)t->limits->points);
    return false;
  }
  d->edge[a] = task_take(t, (int64_t)cells + 1, sizeof *d->edge[a]);
  if (!d->edge[a]) return false;
  double *edge = d->edge[a];
  for (int64_t k = 0; k + 1 < n; k++) {
    const int64_t m = (int64_t)segment(d, at[k + 1] - at[k]);
    sct_flow_lines(at[k], at[k + 1], m, clustering, edge);
    edge += m;
  }
  d->domain.cells[a] = (int64_t)cells;
  return true;
}

static bool read_lines(task *t, const item *it, flow_domain_input *d) {
  static const char *const members[] = {"x", "y", NULL};
  bool good = read_object(t, it, members);
  for (int a = 0; a < 2 && good; a++) {
    item lines = item_member(it, members[a]);
    numbers list = {0};
    good = read_required(t, &lines) && read_numbers(t, &lines, 1, &list);
    if (good && list.rows < 3) {
      complain(t, &lines, "has %lld lines, needs 3 or more", (long long)list.rows);
      good = false;
    }
    d->edge[a] = (double *)list.data;
    d->domain.cells[a] = list.rows - 1;
  }
  return good;
}

static bool cells_are_allowed(task *t, const item *it, const flow_domain_input *d) {
  const double cells = (double)d->domain.cells[0] * (double)d->domain.cells[1];
  if (cells <= (double)t->limits->points) return true;
  complain(t, it, "has a mesh of %.0f cells, at most %lld are allowed", cells,
           (long long)t->limits->points);
  return false;
}

bool flow_domain_input_read(task *t, const item *it, double clustering, flow_domain_input *d) {
  static const char *const members[] = {"fluid", "solid", "sides", "spacing", "lines", NULL};
  item fluid = item_member(it, "fluid"), solid = item_member(it, "solid");
  item sides = item_member(it, "sides"), spacing = item_member(it, "spacing");
  item lines = item_member(it, "lines");
  if (!read_object(t, it, members)) return false;
  bool good = read_required(t, &fluid) && read_boxes(t, &fluid, &d->fluid, &d->domain.fluids);
  if (good && d->domain.fluids == 0) {
    complain(t, &fluid, "is empty, needs a box");
    good = false;
  }
  good &= read_boxes(t, &solid, &d->solid, &d->domain.solids);
  good &= read_sides(t, &sides, d);
  good &= read_number(t, &spacing, &range_positive, &d->spacing);
  if (lines.doc) {
    good &= read_lines(t, &lines, d);
  } else {
    good &= read_required(t, &spacing);
    for (int a = 0; a < 2 && good; a++) good = lay_axis(t, &spacing, d, a, clustering);
  }
  for (int a = 0; a < 2; a++) d->domain.edge[a] = d->edge[a];
  d->domain.fluid = d->fluid;
  d->domain.solid = d->solid;
  d->domain.side = d->side;
  return good && cells_are_allowed(t, it, d);
}
