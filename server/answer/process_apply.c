/* process_apply.c - the operators applied to a field. */
#include <math.h>

#include "diagnostics.h"
#include "estimate.h"
#include "field_input.h"
#include "member.h"
#include "operator_input.h"
#include "parameters_input.h"
#include "process.h"
#include "report.h"

static const char *const inputs[] = {"cloud",          "parameters",      "operator", "field",
                                     "exact_gradient", "exact_laplacian", NULL};

/* Bits of `wanted`: the outputs in their order. */
enum { VALUE = 1, GRADIENT = 2, LAPLACIAN = 4, NORMS = 8, DIAGNOSTICS = 16 };

typedef struct {
  cloud_input cloud;
  sct_operator op;
  field phi, exact_gradient, exact_laplacian;
  discretisation grid;
  double *value, *gradient, *laplacian; /* by the client's numbers */
  uint8_t *flags;                       /* [n] by place, SCT_ROW_*; NULL: no rows were made */
  sct_norms gradient_norms, laplacian_norms;
  diagnostics diagnostics;
} apply;

static void read_apply(task *t, const item *in, void *state) {
  apply *s = state;
  item parameters = item_input(in, "parameters"), cloud = item_input(in, "cloud");
  item op = item_input(in, "operator"), phi = item_input(in, "field");
  item gradient = item_input(in, "exact_gradient"), laplacian = item_input(in, "exact_laplacian");
  parameters_input_read(t, &parameters);
  bool has_cloud = cloud_input_read(t, &cloud, &s->cloud);
  operator_input_read(t, &op, &s->op);
  sites all = has_cloud ? sites_all(&s->cloud) : (sites){0};
  const sites *on = has_cloud ? &all : NULL;
  if (read_required(t, &phi)) read_scalar_field(t, &phi, on, 0, &s->phi);
  read_vector_field(t, &gradient, on, 0, &s->exact_gradient);
  read_scalar_field(t, &laplacian, on, 0, &s->exact_laplacian);
}

/* What was made of a field may be too large for a double: then there is no answer. */
static sct_status check_finite(task *t, const char *what, const double *made, int64_t n,
                               int components) {
  for (int64_t k = 0; made && k < n * components; k++) {
    if (isfinite(made[k])) continue;
    return sct_fail(&t->error, SCT_E_NOT_FINITE, k / components, "has a %s that is not finite",
                    what);
  }
  return SCT_OK;
}

/* Applies what is wanted, and hands it out in the client's numbers. */
static sct_status apply_operators(task *t, unsigned wanted, const uint8_t *mask, apply *s) {
  const cloud_input *c = &s->cloud;
  const int64_t n = c->cloud.n;
  const int dim = c->cloud.dim;
  bool is_compared = wanted & NORMS;
  bool has_gradient = (wanted & GRADIENT) || (is_compared && s->exact_gradient.value);
  bool has_laplacian = (wanted & LAPLACIAN) || (is_compared && s->exact_laplacian.value);
  double *value = wanted & VALUE ? task_take(t, n, sizeof *value) : NULL;
  double *gradient = has_gradient ? task_take(t, n * dim, sizeof *gradient) : NULL;
  double *laplacian = has_laplacian ? task_take(t, n, sizeof *laplacian) : NULL;
  const bool has_rows = (wanted & DIAGNOSTICS) && (gradient || laplacian);
  if (has_rows) s->flags = task_take(t, n, sizeof *s->flags);
  if (t->error.code) return t->error.code;
  if (sct_stencil_apply_flagged(s->grid.stencil, s->phi.value, &t->work, value, gradient, laplacian,
                                s->flags, &t->error)) {
    return t->error.code;
  }
  if (check_finite(t, "smoothed value", value, n, 1) ||
      check_finite(t, "gradient", gradient, n, dim) ||
      check_finite(t, "Laplacian", laplacian, n, 1)) {
    return t->error.code;
  }
  if (gradient && s->exact_gradient.value) {
    s->gradient_norms = sct_norms_of(gradient, s->exact_gradient.value, n, dim, mask);
  }
  if (laplacian && s->exact_laplacian.value) {
    s->laplacian_norms = sct_norms_of(laplacian, s->exact_laplacian.value, n, 1, mask);
  }
  if (value) s->value = cloud_input_restore(t, c, value, 1);
  if (gradient) s->gradient = cloud_input_restore(t, c, gradient, dim);
  if (laplacian) s->laplacian = cloud_input_restore(t, c, laplacian, 1);
  return t->error.code;
}

static sct_status run_apply(task *t, unsigned wanted, void *state) {
  apply *s = state;
  sct_diagnosis all = {0};
  if (discretisation_build(t, &s->cloud, &s->op, &s->grid)) return t->error.code;
  uint8_t *mask = cloud_input_interior(t, &s->cloud);
  if (!mask) return t->error.code;
  if (sct_work_report(&t->work, "apply", 0, &t->error)) return t->error.code;
  if (apply_operators(t, wanted, mask, s)) return t->error.code;
  stopwatch_lap(&t->watch, LAP_SOLVE);
  if (!(wanted & DIAGNOSTICS)) return SCT_OK;
  if (!diagnosis_take(t, &s->cloud, &all)) return t->error.code;
  (void)diagnostics_of_cloud(t, &s->cloud, &s->grid, &all, mask, &s->diagnostics);
  if (s->flags) diagnostics_of_rows(s->flags, s->cloud.cloud.n, &s->diagnostics);
  stopwatch_lap(&t->watch, LAP_STENCIL);
  return t->error.code;
}

static int64_t memory_of_apply(const task *t, const void *state) {
  const apply *s = state;
  (void)t;
  return estimate_points(s->cloud.cloud.dim, s->cloud.cloud.n, &s->op);
}

static void clear_apply(void *state) {
  apply *s = state;
  discretisation_clear(&s->grid);
}

static void write_value(emit *e, const task *t, const void *state) {
  const apply *s = state;
  (void)t;
  emit_array(e, s->value, s->cloud.cloud.n);
}

static void write_gradient(emit *e, const task *t, const void *state) {
  const apply *s = state;
  (void)t;
  emit_rows(e, s->gradient, s->cloud.cloud.n, s->cloud.cloud.dim);
}

static void write_laplacian(emit *e, const task *t, const void *state) {
  const apply *s = state;
  (void)t;
  emit_array(e, s->laplacian, s->cloud.cloud.n);
}

static void write_norms(emit *e, const task *t, const void *state) {
  const apply *s = state;
  (void)t;
  emit_object(e);
  if (s->exact_gradient.value) {
    emit_key(e, "gradient");
    emit_norms(e, &s->gradient_norms);
  }
  if (s->exact_laplacian.value) {
    emit_key(e, "laplacian");
    emit_norms(e, &s->laplacian_norms);
  }
  emit_end(e);
}

static void write_diagnostics(emit *e, const task *t, const void *state) {
  (void)t;
  diagnostics_write(e, &((const apply *)state)->diagnostics);
}

static void write_points(emit *e, const task *t, const void *state) {
  const cloud_input *c = &((const apply *)state)->cloud;
  (void)t;
  emit_rows(e, c->posted, c->cloud.n, c->cloud.dim);
}

const process process_apply = {
    .id = "apply",
    .inputs = inputs,
    .state_size = sizeof(apply),
    .read = read_apply,
    .run = run_apply,
    .clear = clear_apply,
    .memory = memory_of_apply,
    .coordinates = write_points,
    .outputs = {{"value", NULL, false, write_value, OUTPUT_FIELD},
                {"gradient", NULL, false, write_gradient, OUTPUT_FIELD},
                {"laplacian", NULL, false, write_laplacian, OUTPUT_FIELD},
                {"norms", "exact_gradient exact_laplacian", true, write_norms},
                {"diagnostics", NULL, true, write_diagnostics},
                {"report", NULL, true, report_write}},
};
