#include "operator_input.h"

#define NAME(symbol, name) name,
static const char *const schemes[] = {SCT_SCHEME_LIST(NAME) NULL};
static const char *const upwinds[] = {SCT_UPWIND_LIST(NAME) NULL};
static const char *const densities[] = {SCT_DENSITY_LIST(NAME) NULL};
static const char *const weights[] = {SCT_WEIGHT_LIST(NAME) NULL};
#undef NAME

static const char *const members[] = {
    "scheme", "degree",      "weight",           "kernel",          "radius", "number_density",
    "upwind", "gamma_scale", "reference_length", "reference_speed", NULL};

/* The scheme and its degree come first: they decide on the defaults. */
static bool read_scheme(task *t, const item *it, sct_scheme otherwise, sct_operator *op) {
  item scheme = item_member(it, "scheme"), degree = item_member(it, "degree");
  int chosen = (int)otherwise;
  int64_t order = 2;
  bool good = read_choice(t, &scheme, schemes, &chosen);
  good &= read_integer(t, &degree, 2, 4, &order);
  *op = sct_operator_default((sct_scheme)chosen, (int)order);
  return good;
}

/* What only lsmps has: with another scheme a value would change nothing, and who sends one that is
 * not the default expects that it does. */
static bool fits_scheme(task *t, const item *it, const char *member, bool is_default,
                        const sct_operator *op) {
  item found = item_member(it, member);
  if (is_default || op->scheme == SCT_LSMPS) return true;
  complain(t, &found, "is of scheme lsmps only, needs to be left out with %s",
           sct_scheme_name(op->scheme));
  return false;
}

static bool read_kernel(task *t, const item *it, sct_operator *op) {
  enum { NAMES_MAX = 32 };
  const char *names[NAMES_MAX + 1];
  int chosen = -1, count = sct_kernel_count() < NAMES_MAX ? sct_kernel_count() : NAMES_MAX;
  for (int k = 0; k < count; k++) names[k] = sct_kernel_at(k)->name;
  names[count] = NULL;
  if (!read_choice(t, it, names, &chosen)) return false;
  if (chosen >= 0) op->kernel = sct_kernel_at(chosen);
  return true;
}

static bool read_choices(task *t, const item *it, sct_operator *op) {
  item weight = item_member(it, "weight"), density = item_member(it, "number_density");
  item upwind = item_member(it, "upwind"), kernel = item_member(it, "kernel");
  int w = (int)op->weight, d = (int)op->density, u = (int)op->upwind;
  bool good = read_choice(t, &weight, weights, &w);
  good &= read_choice(t, &density, densities, &d);
  good &= read_choice(t, &upwind, upwinds, &u);
  good &= read_kernel(t, &kernel, op);
  op->weight = (sct_weight)w;
  op->density = (sct_density)d;
  op->upwind = (sct_upwind)u;
  return good;
}

static bool read_sizes(task *t, const item *it, sct_operator *op) {
  static const range radii = {1, 8, false, false};
  item radius = item_member(it, "radius"), scale = item_member(it, "gamma_scale");
  item length = item_member(it, "reference_length"), speed = item_member(it, "reference_speed");
  bool good = read_number(t, &radius, &radii, &op->radius);
  good &= read_number(t, &scale, &range_positive, &op->gamma_scale);
  good &= read_number(t, &length, &range_positive, &op->reference_length);
  good &= read_number(t, &speed, &range_positive, &op->reference_speed);
  return good;
}

bool operator_input_read(task *t, const item *it, sct_operator *op) {
  return operator_input_read_else(t, it, SCT_LSMPS, op);
}

bool operator_input_read_else(task *t, const item *it, sct_scheme otherwise, sct_operator *op) {
  sct_error error = {0};
  bool good = read_object(t, it, members);
  if (it->doc && it->doc->kind != DOC_OBJECT) return false;
  good &= read_scheme(t, it, otherwise, op);
  good &= read_choices(t, it, op);
  good &= read_sizes(t, it, op);
  good &= fits_scheme(t, it, "degree", op->degree == 2, op);
  good &= fits_scheme(t, it, "weight", op->weight == SCT_WEIGHT_KERNEL_R2, op);
  if (!good || sct_operator_check(op, &error) == SCT_OK) return good;
  complain(t, it, "%s", error.text);
  return false;
}
