#include "model.h"

#include <string.h>

#include "by_href.h"
#include "doc_make.h"
#include "document.h"

const char model_name[] = "solve";

/* Where things stand in a request. */
typedef struct {
  item config;   /* doc NULL or empty: replaced by the default */
  item inputs;   /* of the solve */
  bool is_whole; /* config is a solve request */
} places;

/* ---- Vectors ---- */

bool model_read_vector(task *t, const item *it, int64_t size, double *value) {
  numbers read = {0, 1, NULL};
  if (!read_required(t, it) || !read_numbers(t, it, 1, &read)) return false;
  if (read.rows != size) {
    complain(t, it, "has %lld numbers, needs %lld", (long long)read.rows, (long long)size);
    return false;
  }
  if (size > 0) memcpy(value, read.data, (size_t)size * sizeof *value);
  return true;
}

/* Vector k of an array of arrays; `row` is where it may be made. */
static const doc *vector_at(const doc *d, int64_t k, doc *row) {
  if (d->kind == DOC_LIST) return doc_at(d, k);
  const int64_t columns = d->shape[1];
  *row = (doc){.kind = DOC_NUMBERS, .rank = 1, .count = columns, .shape = {columns}};
  row->data = d->data + k * columns;
  return row;
}

static int64_t vectors_in(const doc *d) {
  if (d->kind == DOC_LIST) return d->count;
  return d->kind == DOC_NUMBERS && (d->rank == 2 || d->count == 0) ? d->shape[0] : -1;
}

static bool read_input(task *t, const item *it, const model_inputs *in) {
  char room[64];
  doc row;
  bool good = true;
  if (!read_required(t, it)) return false;
  const int64_t count = vectors_in(it->doc);
  if (count != in->vectors) {
    complain(t, it, "is %s, needs an array of %lld arrays of numbers",
             doc_describe(it->doc, room, sizeof room), (long long)in->vectors);
    return false;
  }
  for (int64_t k = 0; k < count; k++) {
    item vector = item_element(it, vector_at(it->doc, k, &row), k);
    good &=
        model_read_vector(t, &vector, in->first[k + 1] - in->first[k], in->value + in->first[k]);
  }
  return good;
}

bool model_read_index(task *t, const item *body, const char *key, int64_t count, int64_t *index) {
  item it = item_member(body, key);
  return read_required(t, &it) && read_integer(t, &it, 0, count - 1, index);
}

/* ---- Names of inputs ---- */

static bool take_names(task *t, int64_t vectors, int64_t count, model_inputs *in) {
  in->vectors = vectors;
  in->first = task_zeros(t, vectors + 1, sizeof *in->first);
  in->name = task_zeros(t, count, sizeof *in->name);
  in->value = task_zeros(t, count, sizeof *in->value);
  return in->first && in->name && in->value;
}

/* All parameters as one vector. */
static bool name_all(task *t, const item *parameters, model_inputs *in) {
  const int64_t count = parameters->doc ? parameters->doc->count : 0;
  if (!take_names(t, 1, count, in)) return false;
  for (const doc *p = parameters->doc ? parameters->doc->child : NULL; p; p = p->next) {
    in->name[in->first[1]] = p->key;
    in->value[in->first[1]++] = p->number;
  }
  return true;
}

static bool is_named(const model_inputs *in, int64_t count, const char *name) {
  for (int64_t k = 0; k < count; k++) {
    if (!strcmp(in->name[k], name)) return true;
  }
  return false;
}

/* The next name, behind the `end` there are. */
static bool take_name(task *t, const item *it, const item *parameters, int64_t *end,
                      model_inputs *in) {
  const char *name = NULL;
  char room[SHOWN_MAX];
  if (!read_text(t, it, &name)) return false;
  const doc *value = doc_member(parameters->doc, name);
  if (!value || is_named(in, *end, name)) {
    complain(t, it, value ? "names \"%s\" a second time" : "\"%s\" is none of the parameters",
             shown(name, room));
    return false;
  }
  in->name[*end] = name;
  in->value[(*end)++] = value->number;
  return true;
}

static bool is_list_of_lists(const doc *d) {
  return d->child && d->child->kind != DOC_TEXT;
}

static bool name_vector(task *t, const item *it, const item *parameters, int64_t *end,
                        model_inputs *in) {
  char room[64];
  bool good = true;
  int64_t k = 0;
  if (it->doc->kind == DOC_NUMBERS && it->doc->count == 0) return true;
  if (it->doc->kind != DOC_LIST) {
    complain(t, it, "is %s, needs an array of names", doc_describe(it->doc, room, sizeof room));
    return false;
  }
  for (const doc *d = it->doc->child; d; d = d->next, k++) {
    item name = item_element(it, d, k);
    good = good && take_name(t, &name, parameters, end, in);
  }
  return good;
}

/* "inputs": [name, ..] or [[name, ..], ..] */
static bool name_listed(task *t, const item *it, const item *parameters, model_inputs *in) {
  const bool nested = it->doc->kind == DOC_LIST && is_list_of_lists(it->doc);
  const int64_t vectors = nested ? it->doc->count : 1;
  const int64_t most = parameters->doc ? parameters->doc->count : 0;
  int64_t end = 0;
  if (!take_names(t, vectors, most, in)) return false;
  for (int64_t k = 0; k < vectors; k++) {
    item vector = nested ? item_element(it, doc_at(it->doc, k), k) : *it;
    if (!name_vector(t, &vector, parameters, &end, in)) return false;
    in->first[k + 1] = end;
  }
  return true;
}

/* ---- Config ---- */

static bool find_config(task *t, const item *body, model *m, places *p) {
  p->config = item_member(body, "config");
  if (!read_object(t, &p->config, NULL)) return false;
  if (!p->config.doc || p->config.doc->count == 0) {
    const doc_limits most = {DOC_DEPTH_MAX, INT32_MAX, INT32_MAX};
    doc_error why;
    p->config.doc = doc_from_json(um_bridge_documents[0].bytes, um_bridge_documents[0].size, &most,
                                  &m->arena, &why);
    if (!p->config.doc) (void)sct_fail(&t->error, SCT_E_MEMORY, -1, "no room for the config");
  }
  if (!p->config.doc) return false;
  p->inputs = item_member(&p->config, "inputs");
  p->is_whole = p->inputs.doc && p->inputs.doc->kind == DOC_OBJECT;
  return true;
}

/* The parameters with the values of the inputs. */
static doc *replaced_parameters(task *t, const item *parameters, const model_inputs *in) {
  doc *made = doc_make_object(t, "parameters");
  for (int64_t k = 0; made && k < in->first[in->vectors]; k++) {
    if (!doc_append(made, doc_make_number(t, in->name[k], in->value[k]))) return NULL;
  }
  if (made && parameters->doc && !doc_add_members(t, parameters->doc, made)) return NULL;
  return made;
}

/* The inputs of the solve: `from` with other parameters and without what is the model's own. */
static doc *replaced_inputs(task *t, const places *p, const item *from, const item *parameters,
                            const model_inputs *in) {
  doc *made = doc_make_object(t, from->key);
  if (!made || !doc_append(made, replaced_parameters(t, parameters, in))) return NULL;
  for (const doc *d = from->doc->child; d; d = d->next) {
    const bool own = !p->is_whole && (!strcmp(d->key, "inputs") || !strcmp(d->key, "outputs"));
    if (own || !strcmp(d->key, "parameters")) continue;
    if (!doc_append(made, doc_make_alias(t, d->key, d))) return NULL;
  }
  return made;
}

static bool read_solve(task *t, const places *p, const item *from, const item *parameters,
                       model *m) {
  item inputs = *from;
  inputs.doc = replaced_inputs(t, p, from, parameters, &m->in);
  if (!inputs.doc) return false;
  bool good = read_object(t, &inputs, solve_inputs) && by_href_resolve(t, &inputs, NULL);
  solve_input_read(t, &inputs, &m->solve.in);
  t->cloud = &m->solve.in.cloud;
  return good && task_is_well(t);
}

/* Names that no solve has, before anything that they may be the reason of. */
static bool config_is_known(task *t, const places *p, const item *from) {
  enum { NAMES_MAX = 32 };
  const char *names[NAMES_MAX + 1];
  int count = 0;
  while (count < NAMES_MAX - 2 && solve_inputs[count]) {
    names[count] = solve_inputs[count];
    count++;
  }
  if (!p->is_whole) {
    names[count++] = "inputs";
    names[count++] = "outputs";
  }
  names[count] = NULL;
  return read_object(t, from, names);
}

static bool read_inputs(task *t, const item *body, const places *p, bool with_input, model *m) {
  const item *from = p->is_whole ? &p->inputs : &p->config;
  item parameters = item_input(from, "parameters"), input = item_member(body, "input");
  if (!config_is_known(t, p, from)) return false;
  if (!read_object(t, &parameters, NULL)) return false;
  for (const doc *d = parameters.doc ? parameters.doc->child : NULL; d; d = d->next) {
    item value = {.doc = d, .up = &parameters, .key = d->key};
    double number;
    if (!read_number(t, &value, &range_any, &number)) return false;
  }
  const bool all = p->is_whole || !p->inputs.doc;
  if (!(all ? name_all(t, &parameters, &m->in) : name_listed(t, &p->inputs, &parameters, &m->in))) {
    return false;
  }
  if (with_input && !read_input(t, &input, &m->in)) return false;
  return read_solve(t, p, from, &parameters, m);
}

/* ---- Outputs ---- */

static bool read_functionals(task *t, const item *it, model *m) {
  bool good = true;
  m->output = task_zeros(t, it->doc->count, sizeof *m->output);
  if (!m->output) return false;
  for (const doc *d = it->doc->child; d; d = d->next, m->outputs++) {
    item one = {.doc = d, .up = it, .key = d->key, .index = m->outputs};
    good &= functional_read(t, &one, &m->solve.in.cloud, &m->output[m->outputs]);
  }
  return good;
}

static bool read_outputs(task *t, const places *p, model *m) {
  static const doc mean = {.kind = DOC_TEXT, .text = "mean", .length = 4};
  static const doc only_mean = {.kind = DOC_LIST, .child = &mean, .count = 1};
  item outputs = item_member(&p->config, "outputs");
  char room[64];
  if (!outputs.doc) outputs.doc = &only_mean;
  const bool has_some = outputs.doc->kind == DOC_LIST || outputs.doc->kind == DOC_OBJECT;
  if (has_some && outputs.doc->count > 0) return read_functionals(t, &outputs, m);
  complain(t, &outputs, "is %s, needs functionals, in an array or an object",
           doc_describe(outputs.doc, room, sizeof room));
  return false;
}

bool model_read(task *t, const item *body, bool with_input, model *m) {
  places p = {0};
  if (!find_config(t, body, m, &p) || !read_inputs(t, body, &p, with_input, m)) return false;
  return read_outputs(t, &p, m);
}

void model_clear(model *m) {
  solve_clear(&m->solve);
  doc_arena_free(&m->arena);
}
