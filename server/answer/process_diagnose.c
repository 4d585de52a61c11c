/* process_diagnose.c - what a cloud does to the operators on it. */
#include "diagnostics.h"
#include "estimate.h"
#include "member.h"
#include "operator_input.h"
#include "process.h"
#include "report.h"

static const char *const inputs[] = {"cloud", "operator", NULL};

typedef struct {
  cloud_input cloud;
  sct_operator op;
  discretisation grid;
  int32_t *neighbours;           /* [n], and so on as in sct_diagnosis, client's numbers */
  double *number_density;        /* [n] */
  double *artificial_velocity;   /* [n][dim] */
  double *effective_diffusivity; /* [n][dim(dim+1)/2] */
  diagnostics summary;
} diagnose;

static void read_diagnose(task *t, const item *in, void *state) {
  diagnose *s = state;
  item cloud = item_input(in, "cloud"), op = item_input(in, "operator");
  cloud_input_read(t, &cloud, &s->cloud);
  operator_input_read(t, &op, &s->op);
}

static int32_t *restore_counts(task *t, const cloud_input *c, const int32_t *value) {
  int32_t *out = task_take(t, c->cloud.n, sizeof *out);
  if (!out) return NULL;
  for (int64_t k = 0; k < c->cloud.n; k++) out[c->order[k]] = value[k];
  return out;
}

static int entries_of(const diagnose *s) {
  return s->cloud.cloud.dim * (s->cloud.cloud.dim + 1) / 2;
}

static sct_status run_diagnose(task *t, unsigned wanted, void *state) {
  diagnose *s = state;
  cloud_input *c = &s->cloud;
  sct_diagnosis all = {0};
  (void)wanted;
  if (discretisation_build(t, c, &s->op, &s->grid)) return t->error.code;
  uint8_t *mask = cloud_input_interior(t, c);
  if (!mask || !diagnosis_take(t, c, &all)) return t->error.code;
  if (diagnostics_of_cloud(t, c, &s->grid, &all, mask, &s->summary)) return t->error.code;
  s->neighbours = restore_counts(t, c, all.neighbours);
  s->number_density = cloud_input_restore(t, c, all.number_density, 1);
  s->artificial_velocity = cloud_input_restore(t, c, all.artificial_velocity, c->cloud.dim);
  s->effective_diffusivity = cloud_input_restore(t, c, all.effective_diffusivity, entries_of(s));
  stopwatch_lap(&t->watch, LAP_STENCIL);
  return t->error.code;
}

static int64_t memory_of_diagnose(const task *t, const void *state) {
  const diagnose *s = state;
  (void)t;
  return estimate_points(s->cloud.cloud.dim, s->cloud.cloud.n, &s->op);
}

static void clear_diagnose(void *state) {
  diagnose *s = state;
  discretisation_clear(&s->grid);
}

static void write_neighbours(emit *e, const task *t, const void *state) {
  const diagnose *s = state;
  (void)t;
  emit_int32s(e, s->neighbours, 1, &s->cloud.cloud.n);
}

static void write_density(emit *e, const task *t, const void *state) {
  const diagnose *s = state;
  (void)t;
  emit_array(e, s->number_density, s->cloud.cloud.n);
}

static void write_velocity(emit *e, const task *t, const void *state) {
  const diagnose *s = state;
  (void)t;
  emit_rows(e, s->artificial_velocity, s->cloud.cloud.n, s->cloud.cloud.dim);
}

static void write_tensor(emit *e, const task *t, const void *state) {
  const diagnose *s = state;
  (void)t;
  emit_rows(e, s->effective_diffusivity, s->cloud.cloud.n, entries_of(s));
}

static void write_summary(emit *e, const task *t, const void *state) {
  (void)t;
  diagnostics_write(e, &((const diagnose *)state)->summary);
}

static void write_points(emit *e, const task *t, const void *state) {
  const cloud_input *c = &((const diagnose *)state)->cloud;
  (void)t;
  emit_rows(e, c->posted, c->cloud.n, c->cloud.dim);
}

const process process_diagnose = {
    .id = "diagnose",
    .inputs = inputs,
    .state_size = sizeof(diagnose),
    .read = read_diagnose,
    .run = run_diagnose,
    .clear = clear_diagnose,
    .memory = memory_of_diagnose,
    .coordinates = write_points,
    .outputs = {{"neighbours", NULL, false, write_neighbours, OUTPUT_COUNTS},
                {"number_density", NULL, false, write_density, OUTPUT_FIELD},
                {"artificial_velocity", NULL, false, write_velocity, OUTPUT_FIELD},
                {"effective_diffusivity", NULL, false, write_tensor, OUTPUT_TENSOR},
                {"summary", NULL, true, write_summary},
                {"report", NULL, true, report_write}},
};
