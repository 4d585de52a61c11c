#include "solve_input.h"

#include "operator_input.h"
#include "parameters_input.h"
#include "time_input.h"

const char *const solve_inputs[] = {"cloud",    "parameters", "velocity", "diffusivity", "source",
                                    "reaction", "boundary",   "operator", "solver",      "time",
                                    "initial",  "exact",      NULL};

static void read_diffusivity(task *t, const item *it, const sites *on, double time,
                             solve_input *s) {
  if (!read_required(t, it)) return;
  if (!read_scalar_field(t, it, on, time, &s->diffusivity) || !on) return;
  for (int64_t k = 0; k < on->n; k++) {
    double value = s->diffusivity.value[k];
    if (value >= 0) continue;
    item entry = item_element(it, NULL, on->client[k]);
    complain(t, item_rank(it) ? &entry : it, "is %.15g at point %d, needs zero or more", value,
             on->client[k]);
    return;
  }
}

static void read_fields(task *t, const item *in, const sites *on, double time, solve_input *s) {
  item velocity = item_input(in, "velocity"), diffusivity = item_input(in, "diffusivity");
  item source = item_input(in, "source"), reaction = item_input(in, "reaction");
  read_vector_field(t, &velocity, on, time, &s->velocity);
  read_diffusivity(t, &diffusivity, on, time, s);
  read_scalar_field(t, &source, on, time, &s->source);
  read_scalar_field(t, &reaction, on, time, &s->reaction);
}

static void read_boundary(task *t, const item *in, cloud_input *c, double time, solve_input *s) {
  item boundary = item_input(in, "boundary");
  if (!boundary_input_read(t, &boundary, c, time, &s->boundary) || !c) return;
  if (s->boundary.constrained < c->cloud.n) return;
  complain(t, &boundary, "gives every point a value, needs at least one point to solve for");
}

/* The input that sets the time step, for messages. */
static void find_step(const item *time, solve_input *s) {
  item step = item_member(time, "step"), number = item_member(time, "diffusion_number");
  item_pointer(step.doc ? &step : number.doc ? &number : time, s->step_pointer);
}

static void read_time(task *t, const item *in, solve_input *s) {
  item time = item_input(in, "time"), solver = item_input(in, "solver");
  item initial = item_input(in, "initial");
  s->is_transient = time.doc != NULL;
  time_input_read(t, &time, &s->march);
  find_step(&time, s);
  solver_input_read(t, &solver, &s->march);
  if (s->is_transient && !initial.doc) {
    complain(t, &initial, "is missing and required: with time the problem starts from it");
  }
}

void solve_input_read(task *t, const item *in, solve_input *s) {
  item parameters = item_input(in, "parameters"), cloud = item_input(in, "cloud");
  item op = item_input(in, "operator"), initial = item_input(in, "initial");
  item exact = item_input(in, "exact");
  parameters_input_read(t, &parameters);
  bool has_cloud = cloud_input_read(t, &cloud, &s->cloud);
  operator_input_read(t, &op, &s->op);
  read_time(t, in, s);
  sites all = has_cloud ? sites_all(&s->cloud) : (sites){0};
  const sites *on = has_cloud ? &all : NULL;
  read_fields(t, in, on, s->march.start, s);
  read_boundary(t, in, has_cloud ? &s->cloud : NULL, s->march.start, s);
  read_scalar_field(t, &initial, on, s->march.start, &s->initial);
  read_scalar_field(t, &exact, on, s->march.end, &s->exact);
  s->march.solve.dim = s->cloud.cloud.dim;
}

sct_fields solve_input_fields(const solve_input *s) {
  return (sct_fields){s->velocity.value, s->diffusivity.value, s->source.value, s->reaction.value};
}

sct_boundary solve_input_boundary(const solve_input *s) {
  const boundary_input *b = &s->boundary;
  return (sct_boundary){b->condition, b->value, b->coefficient, b->normal};
}

int solve_input_varies(const solve_input *s) {
  bool matrix = s->velocity.varies || s->diffusivity.varies || s->reaction.varies ||
                s->boundary.matrix_varies;
  bool value = s->boundary.varies;
  return (matrix ? SCT_VARIES_MATRIX : 0) | (s->source.varies || value ? SCT_VARIES_LOAD : 0) |
         (value ? SCT_VARIES_DIRICHLET : 0);
}

bool solve_input_advance(task *t, solve_input *s, double time) {
  field *const fields[] = {&s->velocity, &s->diffusivity, &s->source, &s->reaction};
  for (int k = 0; k < 4; k++) {
    if (!field_advance(t, fields[k], time)) return false;
  }
  return boundary_input_advance(t, &s->boundary, time);
}
