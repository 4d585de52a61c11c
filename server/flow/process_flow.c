/* process_flow.c - incompressible flow on moving particles. */
#include <math.h>
#include <stdlib.h>
#include <time.h>

#include "flow_input.h"
#include "member.h"
#include "process.h"
#include "report.h"

/* A state is kept at most so often, and not so often that it takes more than a fiftieth of the
 * time. */
static const double CHECKPOINT_SECONDS = 2;

/* Steps between two looks at the clock. */
enum { STEPS_AT_ONCE = 20 };

typedef struct {
  flow_input in;
  sct_flow *flow;
  double resumed; /* time of the state that the run went on from, 0: from the start */
} flow_state;

static void read_flow(task *t, const item *in, void *state) {
  flow_input_read(t, in, &((flow_state *)state)->in);
}

/* ---- running ---- */

static double now(void) {
  struct timespec time;
  clock_gettime(CLOCK_MONOTONIC, &time);
  return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

/* Goes on from a state if there is one. One that does not fit any more (of another version of the
 * program) is as good as none. */
static sct_status resume(task *t, flow_state *s) {
  sct_error why = {0};
  if (!t->checkpoint) return SCT_OK;
  const sct_status status = sct_flow_load(s->flow, t->checkpoint, t->checkpoint_size, &why);
  if (status == SCT_OK) s->resumed = sct_flow_reports(s->flow).time;
  if (status == SCT_E_MEMORY) t->error = why;
  return t->error.code;
}

/* Has the state kept when it is due. To fail at it is no reason to stop. */
static void keep_state(task *t, const flow_state *s, double *due) {
  void *bytes = NULL;
  size_t size = 0;
  const double begun = now();
  if (!t->keep_checkpoint || begun < *due) return;
  if (sct_flow_save(s->flow, &bytes, &size, NULL) == SCT_OK) {
    (void)t->keep_checkpoint(t->work.context, bytes, size);
  }
  free(bytes);
  *due = now() + fmax(CHECKPOINT_SECONDS, 50 * (now() - begun));
}

/* Steps hardly grow in a run: ten times too many are refused when the first ones are known. */
static bool is_hopeless(const task *t, const flow_state *s, const sct_flow_report *r) {
  return r->step > 0 && (s->in.options.end - r->time) / r->step > 10.0 * (double)t->limits->steps;
}

static bool steps_are_allowed(task *t, const flow_state *s) {
  const sct_flow_report r = sct_flow_reports(s->flow);
  if (is_hopeless(t, s, &r)) {
    t->blame = "/inputs/end";
    (void)sct_fail(&t->error, SCT_E_LIMIT, -1, "t = %g needs steps of about %g, the limit is %lld",
                   s->in.options.end, r.step, (long long)t->limits->steps);
    return false;
  }
  if (r.steps < t->limits->steps || sct_flow_is_done(s->flow)) return true;
  t->blame = "/inputs/end";
  (void)sct_fail(&t->error, SCT_E_LIMIT, -1,
                 "t = %g is reached after %lld steps of about %g, which is the limit", r.time,
                 (long long)r.steps, r.step);
  return false;
}

static sct_status run_flow(task *t, unsigned wanted, void *state) {
  flow_state *s = state;
  const sct_flow_domain *domain;
  double due = now() + CHECKPOINT_SECONDS;
  (void)wanted;
  if (flow_input_make(t, &s->in, &domain)) return t->error.code;
  if (sct_flow_build(domain, &s->in.options, &s->flow, &t->error)) return t->error.code;
  t->blame = NULL;
  stopwatch_lap(&t->watch, LAP_FACTOR);
  if (resume(t, s)) return t->error.code;
  while (!sct_flow_is_done(s->flow) && steps_are_allowed(t, s)) {
    if (sct_flow_advance(s->flow, STEPS_AT_ONCE, &t->work, &t->error)) break;
    keep_state(t, s, &due);
  }
  stopwatch_lap(&t->watch, LAP_SOLVE);
  return t->error.code;
}

static void clear_flow(void *state) {
  flow_state *s = state;
  sct_flow_free(&s->flow);
  flow_input_clear(&s->in);
}

/* Particles, sites and rows take some 700 bytes per cell; the factor grows with its logarithm. */
static int64_t flow_memory(const task *t, const void *state) {
  const double cells = flow_input_cells(&((const flow_state *)state)->in);
  (void)t;
  return (int64_t)(cells * (1000 + 100 * log2(cells + 2)));
}

/* ---- writing: particles ---- */

static const sct_flow *flow_of(const void *state) {
  return ((const flow_state *)state)->flow;
}

static void write_particles(emit *e, const task *t, const void *state) {
  const sct_flow_cloud p = sct_flow_particles(flow_of(state));
  (void)t;
  emit_rows(e, p.x, p.n, 2);
}

static void write_velocity(emit *e, const task *t, const void *state) {
  const sct_flow_cloud p = sct_flow_particles(flow_of(state));
  (void)t;
  emit_rows(e, p.u, p.n, 2);
}

static void write_scalar(emit *e, const task *t, const void *state) {
  const sct_flow_cloud p = sct_flow_particles(flow_of(state));
  (void)t;
  emit_array(e, p.c, p.n);
}

static void write_walls(emit *e, const task *t, const void *state) {
  const sct_flow_cloud p = sct_flow_wall_points(flow_of(state));
  (void)t;
  emit_rows(e, p.x, p.n, 2);
}

static void write_snapshot(emit *e, const sct_flow_cloud *p) {
  emit_object(e);
  member_number(e, "t", p->time);
  emit_key(e, "particles");
  emit_rows(e, p->x, p->n, 2);
  emit_key(e, "velocity");
  emit_rows(e, p->u, p->n, 2);
  if (p->c) member_doubles(e, "scalar", p->c, p->n);
  emit_end(e);
}

static void write_snapshots(emit *e, const task *t, const void *state) {
  (void)t;
  emit_list(e);
  for (int64_t k = 0; k < sct_flow_snapshots(flow_of(state)); k++) {
    const sct_flow_cloud p = sct_flow_snapshot(flow_of(state), k);
    write_snapshot(e, &p);
  }
  emit_end(e);
}

/* ---- mesh ---- */

static const sct_flow_domain *domain_of(const flow_state *s) {
  return s->in.shape == FLOW_DOMAIN ? &s->in.domain.domain : &s->in.example.domain;
}

/* Pressure is 0 in solid, which `fluid` tells from it. */
static void write_pressure(emit *e, double *p, int64_t nx, int64_t ny) {
  int32_t *fluid = calloc((size_t)(nx * ny), sizeof *fluid);
  const int64_t shape[2] = {ny, nx};
  for (int64_t k = 0; fluid && k < nx * ny; k++) {
    fluid[k] = !isnan(p[k]);
    if (!fluid[k]) p[k] = 0;
  }
  emit_key(e, "fluid");
  if (fluid) emit_int32s(e, fluid, 2, shape);
  emit_key(e, "pressure");
  emit_rows(e, p, ny, (int)nx);
  free(fluid);
}

static void write_mesh(emit *e, const task *t, const void *state) {
  const flow_state *s = state;
  const sct_flow_domain *d = domain_of(s);
  const int64_t nx = d->cells[0], ny = d->cells[1], cells = nx * ny;
  const int64_t nodes = (nx + 1) * (ny + 1), fx = (nx + 1) * ny, fy = nx * (ny + 1);
  double *room = malloc((size_t)(cells + nodes + fx + fy) * sizeof *room);
  (void)t;
  emit_object(e);
  member_doubles(e, "x", d->edge[0], nx + 1);
  member_doubles(e, "y", d->edge[1], ny + 1);
  if (room) { /* without it the object ends as a key without value, which emit_ok tells */
    double *stream = room + cells, *u = stream + nodes, *v = u + fx;
    sct_flow_mesh(s->flow, false, room, stream, u, v);
    write_pressure(e, room, nx, ny);
    emit_key(e, "stream");
    emit_rows(e, stream, ny + 1, (int)nx + 1);
    emit_key(e, "u");
    emit_rows(e, u, ny, (int)nx + 1);
    emit_key(e, "v");
    emit_rows(e, v, ny + 1, (int)nx);
  } else {
    emit_key(e, "pressure");
  }
  free(room);
  emit_end(e);
}

/* ---- profiles ---- */

/* Members of a section: `s` along it and the velocity across it. */
static void write_section(emit *e, const sct_flow *f, int along, double at) {
  static const char *const places[] = {"y", "x"}, *const values[] = {"u", "v"};
  const int64_t most = sct_flow_section_most(f, along);
  double *s = malloc((size_t)(2 * most) * sizeof *s);
  const int64_t n = s ? sct_flow_section(f, false, along, at, s, s + most) : 0;
  if (s) member_doubles(e, places[along], s, n);
  emit_key(e, values[along]); /* without memory a key without value, which emit_ok tells */
  if (s) emit_array(e, s + most, n);
  free(s);
}

static void write_centreline(emit *e, const flow_state *s, int along) {
  const sct_flow_domain *d = domain_of(s);
  const double *edge = d->edge[along], at = (edge[0] + edge[d->cells[along]]) / 2;
  member_object(e, along == 0 ? "u" : "v");
  member_number(e, along == 0 ? "x" : "y", at);
  write_section(e, s->flow, along, at);
  emit_end(e);
}

/* Sections of the step in heights of it. */
static void write_sections(emit *e, const flow_state *s) {
  static const double at[] = {0.5, 1, 2, 3, 4, 6, 8};
  const double height = s->in.example.step_height;
  emit_key(e, "sections");
  emit_list(e);
  for (int k = 0; k < (int)(sizeof at / sizeof *at) && at[k] * height < s->in.downstream; k++) {
    emit_object(e);
    member_number(e, "x", at[k]);
    write_section(e, s->flow, 0, at[k] * height);
    emit_end(e);
  }
  emit_end(e);
}

static void write_profiles(emit *e, const task *t, const void *state) {
  const flow_state *s = state;
  (void)t;
  emit_object(e);
  if (s->in.shape == FLOW_STEP) write_sections(e, s);
  if (s->in.shape != FLOW_STEP) write_centreline(e, s, 0);
  if (s->in.shape != FLOW_STEP) write_centreline(e, s, 1);
  emit_end(e);
}

/* ---- numbers ---- */

static void write_vortex(emit *e, const task *t, const void *state) {
  const sct_flow_vortex v = sct_flow_find_vortex(flow_of(state), false);
  (void)t;
  emit_object(e);
  member_number(e, "x", v.x);
  member_number(e, "y", v.y);
  member_number(e, "circulation", v.circulation);
  emit_end(e);
}

/* 0 where the flow does not separate. */
static void write_reattachment(emit *e, const task *t, const void *state) {
  const flow_state *s = state;
  const double x = sct_flow_reattachment(s->flow, false, 0, 0);
  (void)t;
  emit_number(e, isfinite(x) ? x / s->in.example.step_height : 0);
}

static const struct {
  const char *name;
  size_t offset;
} columns[] = {{"t", offsetof(sct_flow_sample, t)},
               {"circulation", offsetof(sct_flow_sample, circulation)},
               {"particles", offsetof(sct_flow_sample, particles)},
               {"divergence", offsetof(sct_flow_sample, divergence)},
               {"divergence_before", offsetof(sct_flow_sample, divergence_before)},
               {"cell_reynolds", offsetof(sct_flow_sample, cell_reynolds)},
               {"diffusivity_mean", offsetof(sct_flow_sample, diffusivity_mean)},
               {"diffusivity_rms", offsetof(sct_flow_sample, diffusivity_rms)},
               {"empty", offsetof(sct_flow_sample, empty)},
               {"crowded", offsetof(sct_flow_sample, crowded)},
               {"nearest", offsetof(sct_flow_sample, nearest)},
               {"nearest_1", offsetof(sct_flow_sample, nearest_1)},
               {"limited", offsetof(sct_flow_sample, limited)},
               {"speed", offsetof(sct_flow_sample, speed)},
               {"scalar", offsetof(sct_flow_sample, scalar)}};

static void write_history(emit *e, const task *t, const void *state) {
  const flow_state *s = state;
  const sct_flow_sample *row;
  const int64_t n = sct_flow_history(s->flow, &row);
  const size_t count = sizeof columns / sizeof *columns - !s->in.options.has_scalar;
  double *value = malloc((size_t)n * sizeof *value);
  (void)t;
  emit_object(e);
  for (size_t c = 0; c < count; c++) {
    for (int64_t k = 0; value && k < n; k++) {
      value[k] = *(const double *)((const char *)&row[k] + columns[c].offset);
    }
    emit_key(e, columns[c].name);
    if (value) emit_array(e, value, n);
  }
  free(value);
  emit_end(e);
}

static void write_summary(emit *e, const task *t, const void *state) {
  const flow_state *s = state;
  const sct_flow_report r = sct_flow_reports(s->flow);
  (void)t;
  emit_object(e);
  member_integer(e, "steps", r.steps);
  member_number(e, "step", r.step);
  member_integer(e, "particles", r.particles);
  member_integer(e, "cells", r.cells);
  member_integer(e, "inserted", r.inserted);
  member_integer(e, "removed", r.removed);
  member_number(e, "circulation_deviation", r.circulation_deviation);
  member_number(e, "viscosity", s->in.options.viscosity);
  if (s->resumed > 0) member_number(e, "resumed", s->resumed);
  emit_end(e);
}

const process process_flow = {
    .id = "flow",
    .inputs = flow_inputs,
    .state_size = sizeof(flow_state),
    .read = read_flow,
    .run = run_flow,
    .clear = clear_flow,
    .memory = flow_memory,
    .coordinates = write_particles,
    .outputs = {{"particles", NULL, false, write_particles, OUTPUT_COORDINATES},
                {"velocity", NULL, false, write_velocity, OUTPUT_FIELD},
                {"scalar", "scalar", false, write_scalar, OUTPUT_FIELD},
                {"wall_points", NULL, false, write_walls, OUTPUT_ARRAY},
                {"snapshots", "save", false, write_snapshots},
                {"mesh", NULL, true, write_mesh},
                {"profiles", NULL, true, write_profiles},
                {"vortex", NULL, true, write_vortex},
                {"reattachment", "case=step", false, write_reattachment},
                {"history", NULL, true, write_history},
                {"summary", NULL, true, write_summary},
                {"report", NULL, true, report_write}},
};
