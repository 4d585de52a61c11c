#include "study_input.h"

#include <math.h>
#include <string.h>

enum { ROWS_MAX = 1000 };

const char *const study_inputs[] = {"case", "cells", "operator", "parameters", NULL};

/* Case and meshes */

static bool read_case(task *t, const item *it, study_input *s) {
  const char *names[STUDY_CASES_MAX + 1];
  int k = -1;
  study_case_names(names);
  if (!read_required(t, it) || !read_choice(t, it, names, &k)) return false;
  s->name = names[k];
  s->root = study_case_open(k, &s->arena);
  if (!s->root) (void)sct_fail(&t->error, SCT_E_MEMORY, -1, "no memory for the case");
  return s->root;
}

static bool read_cells(task *t, const item *it, study_input *s) {
  const doc *cells = doc_member(s->root, "cells");
  s->cells = (numbers){cells->count, 1, cells->data};
  /* n cells make more than n points, so a list of those on a side stays within the limit too. */
  if (!read_integers(t, it, 1, t->limits->points - 1, &s->cells)) return false;
  bool is_only = doc_member(s->root, "one_mesh");
  if (is_only && (s->cells.rows != 1 || s->cells.data[0] != cells->data[0])) {
    complain(t, it, "needs [%.15g]: the case has no other mesh", cells->data[0]);
    return false;
  }
  if (s->cells.rows > 0 && s->cells.rows <= ROWS_MAX) return true;
  complain(t, it, "has %lld meshes, needs 1 to %d", (long long)s->cells.rows, ROWS_MAX);
  return false;
}

/* Operator */

static bool has_text(const doc *d, const char *text) {
  return d && d->kind == DOC_TEXT && !strcmp(d->text, text);
}

/* `own` over the case's operator, unless `own` has another scheme: kernel, radius and all that
 * belong to the scheme they were chosen for. */
static doc *merge_operator(task *t, const study_input *s, const doc *own) {
  const doc *base = doc_member(s->root, "operator"), *scheme = doc_member(own, "scheme");
  bool is_same = !scheme || has_text(scheme, doc_member(base, "scheme")->text);
  doc *merged = doc_make_object(t, NULL);
  if (!merged || (own && !doc_add_members(t, own, merged))) return NULL;
  return !is_same || doc_add_members(t, base, merged) ? merged : NULL;
}

bool study_input_operator(task *t, const study_input *s, const doc *own, sct_operator *op) {
  const item it = item_body(merge_operator(t, s, own));
  return it.doc && operator_input_read(t, &it, op);
}

static bool read_operator(task *t, const item *it, study_input *s) {
  item merged = *it;
  if (it->doc && it->doc->kind != DOC_OBJECT) return read_object(t, it, NULL);
  merged.doc = s->operator_doc = merge_operator(t, s, it->doc);
  return merged.doc && operator_input_read(t, &merged, &s->op);
}

/* Parameters */

static range range_of(const doc *schema) {
  const doc *low = doc_member(schema, "minimum"), *high = doc_member(schema, "maximum");
  const doc *above = doc_member(schema, "exclusiveMinimum");
  const doc *below = doc_member(schema, "exclusiveMaximum");
  return (range){low ? low->number : -INFINITY, high ? high->number : INFINITY,
                 above ? above->truth : !low, below ? below->truth : !high};
}

/* One number as the schema of the parameter has it. */
static bool check_number(task *t, const item *it, const doc *schema) {
  const range allowed = range_of(schema);
  double value;
  int64_t integer;
  if (has_text(doc_member(schema, "type"), "integer")) {
    return read_integer(t, it, (int64_t)allowed.low, (int64_t)allowed.high, &integer);
  }
  return read_number(t, it, &allowed, &value);
}

/* A number that may vary, given as an array. */
static bool check_numbers(task *t, const item *it, const doc *schema) {
  numbers values = {0};
  bool good = true;
  if (!read_numbers(t, it, 1, &values)) return false;
  for (int64_t k = 0; k < values.rows; k++) {
    const doc value = {.kind = DOC_NUMBER, .number = values.data[k]};
    item entry = item_element(it, &value, k);
    good &= check_number(t, &entry, schema);
  }
  if (values.rows > 0) return good;
  complain(t, it, "has no numbers, needs one at least");
  return false;
}

static bool check_parameter(task *t, const item *it, const doc *schema, study_input *s) {
  numbers values = {0};
  bool is_array = has_text(doc_member(schema, "type"), "array");
  bool may_vary = !is_array && strncmp(it->key, "seed", 4);
  if (is_array) return read_numbers(t, it, 1, &values);
  if (!item_rank(it) || !may_vary) return check_number(t, it, schema);
  if (s->varied) {
    complain(t, it, "is an array as \"%s\" is, only one parameter can vary", s->varied->key);
    return false;
  }
  s->varied = it->doc;
  return check_numbers(t, it, schema);
}

/* Complains of members that are no parameters of the case. */
static bool parameters_are_known(task *t, const item *it, const study_input *s) {
  enum { NAMES_MAX = 32 };
  const char *names[NAMES_MAX + 1];
  int n = 0;
  const doc *known = doc_member(s->root, "parameters");
  for (const doc *p = known->child; p && n < NAMES_MAX; p = p->next) names[n++] = p->key;
  names[n] = NULL;
  return read_object(t, it, names);
}

static bool read_parameters(task *t, const item *it, study_input *s) {
  bool good = parameters_are_known(t, it, s);
  if (it->doc && it->doc->kind != DOC_OBJECT) return false;
  s->parameters = doc_make_object(t, NULL);
  if (!s->parameters) return false;
  for (const doc *p = doc_member(s->root, "parameters")->child; p; p = p->next) {
    item given = item_member(it, p->key);
    const doc *value = given.doc ? given.doc : doc_member(p, "default");
    if (given.doc) good &= check_parameter(t, &given, p, s);
    if (!doc_append(s->parameters, doc_make_alias(t, p->key, value))) return false;
  }
  return good;
}

/* All */

static double parameter(const study_input *s, const char *name, double otherwise) {
  const doc *value = doc_member(s->parameters, name);
  return value && value->kind == DOC_NUMBER ? value->number : otherwise;
}

static bool count_rows(task *t, const item *cells, study_input *s) {
  s->rows = s->cells.rows * (s->varied ? s->varied->count : 1);
  if (s->rows <= ROWS_MAX) return true;
  complain(t, cells, "make %lld rows, at most %d are allowed", (long long)s->rows, ROWS_MAX);
  return false;
}

bool study_input_read(task *t, const item *in, study_input *s) {
  item name = item_input(in, "case"), cells = item_input(in, "cells");
  item op = item_input(in, "operator"), parameters = item_input(in, "parameters");
  if (!read_case(t, &name, s)) return false;
  bool good = read_cells(t, &cells, s);
  good &= read_operator(t, &op, s);
  good &= read_parameters(t, &parameters, s);
  if (!good || !count_rows(t, &cells, s)) return false;
  s->seeds = (int64_t)parameter(s, "seeds", 1);
  return true;
}

void study_input_clear(study_input *s) {
  doc_arena_free(&s->arena);
}

bool study_input_scope(task *t, const study_input *s, int64_t k, int64_t cloud, scope *names) {
  const int64_t mesh = k % s->cells.rows, value = k / s->cells.rows;
  bool good = scope_open(t, s->root, s->parameters, names);
  good = good && scope_set(names, "n", s->cells.data[mesh]);
  good = good && scope_set(names, "seed", parameter(s, "seed", 0) + (double)cloud);
  if (s->varied) good = good && scope_set(names, s->varied->key, s->varied->data[value]);
  return good && scope_derive(names);
}
