#include "flow_input.h"

#include "operator_input.h"
#include "parameters_input.h"

const char *const flow_inputs[] = {"case",    "domain",   "cells",        "reynolds",   "viscosity",
                                   "end",     "operator", "grading",      "walls",      "shift",
                                   "courant", "jitter",   "seed",         "downstream", "save",
                                   "samples", "scalar",   "average_from", "parameters", NULL};

static const char *const cases[] = {"cavity", "step", NULL};

/* Complains of inputs that only the other form has. */
static bool refuse_others(task *t, const item *in, const char *const *names, const char *form) {
  bool good = true;
  for (int k = 0; names[k]; k++) {
    item other = item_input(in, names[k]);
    if (!other.doc) continue;
    complain(t, &other, "has no meaning %s", form);
    good = false;
  }
  return good;
}

double flow_input_cells(const flow_input *s) {
  const double n = (double)s->cells;
  const int64_t *own = s->domain.domain.cells;
  if (s->shape == FLOW_DOMAIN) return (double)own[0] * (double)own[1];
  return s->shape == FLOW_CAVITY ? n * n : 2 * n * n * (1 + s->downstream);
}

/* ---- case ---- */

static bool read_case(task *t, const item *in, flow_input *s) {
  static const char *const of_domain[] = {"viscosity", NULL};
  static const char *const of_step[] = {"downstream", NULL};
  item name = item_input(in, "case"), cells = item_input(in, "cells");
  item reynolds = item_input(in, "reynolds"), downstream = item_input(in, "downstream");
  static const range lengths = {2, 1000, false, false};
  int chosen = 0;
  if (!read_choice(t, &name, cases, &chosen)) return false;
  s->shape = chosen == 0 ? FLOW_CAVITY : FLOW_STEP;
  s->cells = chosen == 0 ? 40 : 17;
  s->end = chosen == 0 ? 20 : 60;
  s->reynolds = 100;
  s->downstream = 12;
  bool good = refuse_others(t, in, of_domain, "with a case, whose viscosity `reynolds` says");
  if (chosen == 0) good &= refuse_others(t, in, of_step, "for the cavity");
  good &= read_integer(t, &cells, 4, 4096, &s->cells);
  good &= read_number(t, &reynolds, &range_positive, &s->reynolds);
  good &= read_number(t, &downstream, &lengths, &s->downstream);
  const double all = flow_input_cells(s);
  if (good && all > (double)t->limits->points) {
    complain(t, &cells, "makes about %.3g cells, at most %lld are allowed", all,
             (long long)t->limits->points);
    good = false;
  }
  return good;
}

/* ---- domain ---- */

static bool read_domain(task *t, const item *in, const item *domain, flow_input *s) {
  static const char *const of_case[] = {"cells", "reynolds", "downstream", NULL};
  item viscosity = item_input(in, "viscosity");
  s->shape = FLOW_DOMAIN;
  bool good = refuse_others(t, in, of_case, "with a domain");
  good &= read_required(t, &viscosity) &&
          read_number(t, &viscosity, &range_positive, &s->options.viscosity);
  return flow_domain_input_read(t, domain, s->clustering, &s->domain) && good;
}

static bool read_shape(task *t, const item *in, flow_input *s) {
  item name = item_input(in, "case"), domain = item_input(in, "domain");
  if (domain.doc && name.doc) {
    complain(t, &domain, "stands beside a case, needs one of the two");
    return false;
  }
  if (domain.doc) return read_domain(t, in, &domain, s);
  if (name.doc) return read_case(t, in, s);
  complain(t, &name, "is missing and required, if there is no domain");
  return false;
}

/* ---- how it is run ---- */

static bool read_grading(task *t, const item *in, flow_input *s) {
  static const char *const members[] = {"clustering", NULL};
  static const range amounts = {0, 0.9, false, false};
  item it = item_input(in, "grading");
  item clustering = item_member(&it, "clustering");
  if (!it.doc || it.doc->kind == DOC_NULL) return true;
  return read_object(t, &it, members) && read_number(t, &clustering, &amounts, &s->clustering);
}

static bool read_operator(task *t, const item *in, flow_input *s) {
  static const struct {
    const char *member, *needed;
  } others[] = {{"scheme", "ps, ips, ipsn or lsmps"},
                {"upwind", "none: particles need no convection term"},
                {"number_density", "local"},
                {"degree", "2"},
                {"weight", "kernel/r2"},
                {"radius", "at most 3"}};
  item it = item_input(in, "operator");
  sct_operator *op = &s->options.op;
  if (!operator_input_read_else(t, &it, SCT_IPS, op)) return false;
  const bool wrong[] = {
      op->scheme == SCT_MPS, op->upwind != SCT_UPWIND_NONE,      op->density != SCT_DENSITY_LOCAL,
      op->degree != 2,       op->weight != SCT_WEIGHT_KERNEL_R2, op->radius > 3};
  bool good = true;
  for (int k = 0; k < (int)(sizeof wrong / sizeof *wrong); k++) {
    item member = item_member(&it, others[k].member);
    if (!wrong[k] || (k > 0 && wrong[0])) continue;
    complain(t, &member, "is not for a flow, needs %s", others[k].needed);
    good = false;
  }
  return good;
}

static bool read_numbers_of(task *t, const item *in, flow_input *s) {
  static const range zero_to_one = {0, 1, false, false}, above = {0, 1, true, false},
                     below = {0, 1, false, true};
  sct_flow_options *o = &s->options;
  item shift = item_input(in, "shift"), courant = item_input(in, "courant");
  item jitter = item_input(in, "jitter"), seed = item_input(in, "seed");
  item samples = item_input(in, "samples"), walls = item_input(in, "walls");
  const char *names[SCT_FLOW_WALLS_COUNT + 1] = {NULL};
  int chosen = 0;
  int64_t number = 0;
  for (int k = 0; k < SCT_FLOW_WALLS_COUNT; k++) names[k] = sct_flow_walls_name((sct_flow_walls)k);
  bool good = read_number(t, &shift, &zero_to_one, &o->shift);
  good &= read_number(t, &courant, &above, &o->courant);
  good &= read_number(t, &jitter, &below, &o->jitter);
  good &= read_integer(t, &seed, 0, (INT64_C(1) << 53) - 1, &number);
  good &= read_integer(t, &samples, 1, 10000, &o->samples);
  good &= read_choice(t, &walls, names, &chosen);
  o->seed = (uint64_t)number;
  o->walls = (sct_flow_walls)chosen;
  return good;
}

static bool read_saves(task *t, const item *it, flow_input *s) {
  numbers times = {0};
  bool good = read_numbers(t, it, 1, &times);
  for (int64_t k = 0; k < times.rows && good; k++) {
    const double before = k > 0 ? times.data[k - 1] : 0;
    if (times.data[k] > before && times.data[k] <= s->options.end) continue;
    item entry = item_element(it, NULL, k);
    complain(t, &entry, "is %.15g, needs a time above %.15g up to the end, %.15g", times.data[k],
             before, s->options.end);
    good = false;
  }
  s->options.save = times.data;
  s->options.saves = times.rows;
  return good;
}

static bool read_times(task *t, const item *in, flow_input *s) {
  item end = item_input(in, "end"), save = item_input(in, "save");
  item from = item_input(in, "average_from");
  double average = -1;
  s->options.end = s->end;
  if (s->shape == FLOW_DOMAIN && !read_required(t, &end)) return false;
  if (!read_number(t, &end, &range_positive, &s->options.end)) return false;
  const range within = {0, s->options.end, false, true};
  s->end = s->options.end;
  bool good = read_number(t, &from, &within, &average);
  s->options.average_from = from.doc ? average : 0.75 * s->end;
  return read_saves(t, &save, s) && good;
}

static bool read_scalar(task *t, const item *in, flow_input *s) {
  static const char *const members[] = {"diffusivity", "initial", NULL};
  item it = item_input(in, "scalar");
  item diffusivity = item_member(&it, "diffusivity"), initial = item_member(&it, "initial");
  if (!it.doc) return true;
  if (!read_object(t, &it, members) || !read_required(t, &diffusivity)) return false;
  s->options.has_scalar = true;
  s->options.initial = flow_field_values;
  s->options.context = &s->initial;
  return read_number(t, &diffusivity, &range_not_negative, &s->options.diffusivity) &
         flow_field_read_scalar(t, &initial, &s->initial);
}

void flow_input_read(task *t, const item *in, flow_input *s) {
  item parameters = item_input(in, "parameters");
  s->options = sct_flow_default(SCT_IPS, 1, 1);
  s->options.max_particles = t->limits->points;
  parameters_input_read(t, &parameters);
  read_grading(t, in, s);
  read_shape(t, in, s); /* what is wrong there does not hide the rest */
  if (s->shape == FLOW_STEP) s->options.shift = 0.5;
  read_operator(t, in, s);
  read_numbers_of(t, in, s);
  read_times(t, in, s);
  read_scalar(t, in, s);
}

/* ---- making ---- */

/* The example's domain with the options that were read; viscosity is the example's. */
static sct_status make_case(task *t, flow_input *s) {
  sct_flow_case *c = &s->example;
  const sct_scheme scheme = s->options.op.scheme;
  const sct_status status =
      s->shape == FLOW_CAVITY
          ? sct_flow_cavity(s->cells, s->reynolds, s->clustering, scheme, s->end, c, &t->error)
          : sct_flow_step(s->cells, s->reynolds, s->clustering, s->downstream, scheme, s->end, c,
                          &t->error);
  s->options.viscosity = c->options.viscosity;
  return status;
}

sct_status flow_input_make(task *t, flow_input *s, const sct_flow_domain **domain) {
  const bool is_case = s->shape != FLOW_DOMAIN;
  t->blame = is_case ? "/inputs/cells" : "/inputs/domain";
  *domain = is_case ? &s->example.domain : &s->domain.domain;
  return is_case ? make_case(t, s) : SCT_OK;
}

void flow_input_clear(flow_input *s) {
  sct_flow_case_clear(&s->example);
}
