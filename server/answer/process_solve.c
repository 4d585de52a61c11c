/* process_solve.c - d phi / dt + u . grad phi = div(mu grad phi) + s - k phi on a cloud. */
#include <string.h>

#include "by_ranks.h"
#include "estimate.h"
#include "member.h"
#include "process_solve.h"
#include "report.h"
#include "solve_by_ranks.h"

/* Bits of `wanted`: the outputs in their order. */
enum { SOLUTION = 1, POINTS = 2, NORMS = 4, DIAGNOSTICS = 8, HISTORY = 16 };

enum { SAVED_TEXT = 32 /* bytes: a saved value in a result that doubles as it grows */ };

static void read_solve(task *t, const item *in, void *state) {
  solve_input_read(t, in, &((solve *)state)->in);
}

/* Preparation */

static sct_status assemble(task *t, solve *s, sct_system **system, sct_error *err) {
  const sct_fields fields = solve_input_fields(&s->in);
  const sct_boundary boundary = solve_input_boundary(&s->in);
  return sct_system_build(s->grid.stencil, &fields, &boundary, &t->work, system, err);
}

static void set_dirichlet(const solve *s, double *phi) {
  const boundary_input *b = &s->in.boundary;
  for (int64_t i = 0; i < s->in.cloud.cloud.n; i++) {
    if (b->condition[i] == SCT_DIRICHLET) phi[i] = b->value[i];
  }
}

static bool find_interior(task *t, solve *s) {
  int64_t n = s->in.cloud.cloud.n, interior = 0;
  uint8_t *mask = task_take(t, n, 1);
  if (!mask) return false;
  for (int64_t i = 0; i < n; i++) {
    mask[i] = s->in.boundary.condition[i] == SCT_INTERIOR;
    interior += mask[i];
  }
  s->mask = interior ? mask : NULL;
  return true;
}

/* The solution as far as it is given. */
static sct_status begin_solution(task *t, solve *s) {
  int64_t n = s->in.cloud.cloud.n;
  s->phi = task_zeros(t, n, sizeof *s->phi);
  if (!s->phi || !find_interior(t, s)) return t->error.code;
  if (s->in.is_transient) memcpy(s->phi, s->in.initial.value, (size_t)n * sizeof *s->phi);
  set_dirichlet(s, s->phi);
  return SCT_OK;
}

static sct_status prepare(task *t, solve *s) {
  if (discretisation_build(t, &s->in.cloud, &s->in.op, &s->grid)) return t->error.code;
  if (sct_work_report(&t->work, "assemble", 0, &t->error)) return t->error.code;
  (void)assemble(t, s, &s->system, &t->error);
  stopwatch_lap(&t->watch, LAP_ASSEMBLE);
  return t->error.code;
}

/* Steady */

/* A matrix as badly conditioned as this, or nobody knows how badly, may be singular but for
 * rounding. */
static const double SUSPICIOUS = 1e-12;

static sct_status factor(task *t, solve *s) {
  const sct_csr *a = s->system->matrix;
  if (sct_work_report(&t->work, "factor", 0, &t->error)) return t->error.code;
  sct_solve_options options = s->in.march.solve;
  options.is_equation = s->system->is_equation;
  options.work = &t->work;
  if (s->system->limited) sct_limited_relax(&options);
  sct_status status = sct_solver_analyse(a, &options, &s->solver, &t->error);
  if (!status) status = sct_solver_factor(s->solver, a, &t->error);
  stopwatch_lap(&t->watch, LAP_FACTOR);
  bool is_suspicious = status == SCT_E_SINGULAR ||
                       (!status && sct_solver_report(s->solver)->reciprocal_condition < SUSPICIOUS);
  /* where the cause is known it replaces what the solver says */
  if (is_suspicious && sct_system_explain(s->system, &t->error)) {
    if (t->error.count == 0) t->blame = "/inputs/boundary"; /* no point more than another */
    return SCT_E_SINGULAR;
  }
  return status;
}

static sct_status solve_linear(task *t, solve *s) {
  const int64_t m = s->system->unknowns;
  double *b = task_take(t, m, sizeof *b), *x = task_take(t, m, sizeof *x);
  if (!b || !x) return t->error.code;
  sct_system_rhs(s->system, s->phi, b);
  if (sct_solver_solve(s->solver, b, false, x, &t->error)) return t->error.code;
  for (int64_t row = 0; row < m; row++) s->phi[s->system->point_of[row]] = x[row];
  return SCT_OK;
}

static sct_status solve_limited(task *t, solve *s) {
  return sct_limited_solve(s->system, s->solver, &s->in.march.limited, &t->work, s->phi,
                           &s->march.limited, &t->error);
}

static sct_status solve_steady(task *t, solve *s) {
  if (factor(t, s)) return t->error.code;
  if (sct_work_report(&t->work, "solve", 0, &t->error)) return t->error.code;
  const sct_status status = s->system->limited ? solve_limited(t, s) : solve_linear(t, s);
  if (status) return status;
  s->solve = *sct_solver_report(s->solver);
  stopwatch_lap(&t->watch, LAP_SOLVE);
  return SCT_OK;
}

/* In time */

sct_status solve_advance(void *of, double time, sct_system **system, double *phi, sct_error *err) {
  const solve_context *c = of;
  solve *s = c->s;
  sct_system *next = NULL;
  if (!solve_input_advance(c->t, &s->in, time)) {
    return sct_fail(err, SCT_E_NOT_FINITE, -1, "a field is not finite at t = %.15g", time);
  }
  if (solve_input_varies(&s->in) & SCT_VARIES_MATRIX) {
    sct_status status = assemble(c->t, s, &next, err);
    if (status) return status;
    sct_system_free(system);
    *system = next;
  } else {
    sct_system_load(*system, s->in.source.value, s->in.boundary.value);
  }
  set_dirichlet(s, phi);
  return SCT_OK;
}

static bool take_history(task *t, solve *s) {
  int64_t saves = s->in.march.saves, n = s->in.cloud.cloud.n;
  if (saves > 0 && n > INT64_MAX / saves) saves = INT64_MAX / n;
  s->saved_time = task_take(t, saves, sizeof *s->saved_time);
  s->saved_l2 = task_take(t, saves, sizeof *s->saved_l2);
  s->saved_linf = task_take(t, saves, sizeof *s->saved_linf);
  s->saved_solution = task_take(t, saves * n, sizeof *s->saved_solution);
  return t->error.code == SCT_OK;
}

/* Keeps phi if this is the next time to save; the march hands out its end, too. */
static sct_status save(void *of, double time, const double *phi, sct_error *err) {
  const solve_context *c = of;
  solve *s = c->s;
  const cloud_input *cloud = &s->in.cloud;
  const int64_t n = cloud->cloud.n, k = s->saved;
  if (k >= s->in.march.saves || time < s->in.march.save[k]) return SCT_OK;
  s->saved_time[k] = s->in.march.save[k];
  for (int64_t i = 0; i < n; i++) s->saved_solution[k * n + cloud->order[i]] = phi[i];
  if (s->in.exact.value) {
    if (!field_advance(c->t, &s->in.exact, time)) {
      return sct_fail(err, SCT_E_NOT_FINITE, -1, "exact is not finite at t = %.15g", time);
    }
    sct_norms norms = sct_norms_of(phi, s->in.exact.value, n, 1, s->mask);
    s->saved_l2[k] = norms.l2;
    s->saved_linf[k] = norms.linf;
  }
  s->saved++;
  return SCT_OK;
}

static sct_status solve_in_time(task *t, solve *s) {
  solve_context c = {t, s};
  const sct_march_problem in_time = {
      .varies = solve_input_varies(&s->in), .context = &c, .advance = solve_advance, .save = save};
  if (!take_history(t, s)) return t->error.code;
  sct_status status =
      sct_march(&s->system, &s->in.march, &in_time, &t->work, s->phi, &s->march, &t->error);
  s->solve = s->march.solve;
  if (status == SCT_E_UNSTABLE || status == SCT_E_LIMIT) t->blame = s->in.step_pointer;
  stopwatch_lap(&t->watch, LAP_SOLVE);
  if (!status && !field_advance(t, &s->in.exact, s->in.march.end)) status = SCT_E_NOT_FINITE;
  return status;
}

static int64_t memory_of_solve(const task *t, const void *state) {
  const solve *s = state;
  const sct_cloud *c = &s->in.cloud.cloud;
  const sct_operator *op = &s->in.op;
  const bool is_explicit = s->in.is_transient && s->in.march.method == SCT_FORWARD_EULER;
  const int matrices = s->in.is_transient && !is_explicit ? 2 : 1;
  const int64_t solver = is_explicit        ? 0
                         : t->processes > 1 ? estimate_iteration(c->dim, c->n, op)
                                            : estimate_solver(c->dim, c->n, op, &s->in.march.solve);
  return estimate_points(c->dim, c->n, op) + matrices * estimate_matrix(c->dim, c->n, op) +
         estimate_limited(c->dim, c->n, op) + solver +
         s->in.march.saves * c->n * (int64_t)(sizeof(double) + SAVED_TEXT);
}

/* Results */

static void of_parts(const sct_ranks_report *r, diagnostics *d) {
  d->is_solve = true;
  d->rows = r->unknowns;
  d->nonzeros = r->nonzeros;
  d->widened = r->widened;
  d->fallback = r->fallback;
  d->loose = r->loose;
}

/* After a run by ranks there are no stencils of the whole cloud yet. */
static sct_status diagnose(task *t, solve *s) {
  const cloud_input *c = &s->in.cloud;
  sct_diagnosis all = {0};
  diagnostics *d = &s->diagnostics;
  if (!s->grid.stencil && discretisation_build(t, c, &s->in.op, &s->grid)) return t->error.code;
  if (!diagnosis_take(t, c, &all)) return t->error.code;
  if (diagnostics_of_cloud(t, c, &s->grid, &all, s->mask, d)) return t->error.code;
  diagnostics_of_fields(s->in.velocity.value, s->in.diffusivity.value, c->cloud.n, s->mask, d);
  if (s->system) diagnostics_of_system(s->system, d);
  if (!s->system) of_parts(&t->ranks->report, d);
  d->bounds = sct_range_of(s->phi, c->cloud.n, 1, NULL);
  d->solve = s->solve;
  d->is_transient = s->in.is_transient;
  d->march = s->march;
  if (d->is_transient) d->march.stable_step = sct_march_stable_step(s->system, NULL);
  stopwatch_lap(&t->watch, LAP_STENCIL);
  return SCT_OK;
}

sct_status solve_compute(task *t, solve *s) {
  sct_status status = begin_solution(t, s);
  if (status) return status;
  if (t->ranks && t->ranks->group) {
    if (solve_by_ranks(t, s)) return SCT_OK;
    if (t->ranks->leaves) return SCT_E_CANCELLED; /* without a reply */
    if (t->error.code) return t->error.code;
  }
  status = prepare(t, s);
  if (!status) status = s->in.is_transient ? solve_in_time(t, s) : solve_steady(t, s);
  if (status == SCT_E_CONVERGENCE) t->blame = "/inputs/solver";
  return status;
}

static sct_status run_solve(task *t, unsigned wanted, void *state) {
  solve *s = state;
  const cloud_input *c = &s->in.cloud;
  sct_status status = solve_compute(t, s);
  if (!status && (wanted & DIAGNOSTICS)) status = diagnose(t, s);
  if (status) return status;
  if (s->in.exact.value) {
    s->norms = sct_norms_of(s->phi, s->in.exact.value, c->cloud.n, 1, s->mask);
  }
  s->solution = cloud_input_restore(t, c, s->phi, 1);
  return t->error.code;
}

void solve_clear(void *state) {
  solve *s = state;
  sct_solver_free(&s->solver);
  sct_system_free(&s->system);
  discretisation_clear(&s->grid);
}

/* Writing */

static void write_solution(emit *e, const task *t, const void *state) {
  const solve *s = state;
  (void)t;
  emit_array(e, s->solution, s->in.cloud.cloud.n);
}

static void write_points(emit *e, const task *t, const void *state) {
  const sct_cloud *cloud = &((const solve *)state)->in.cloud.cloud;
  (void)t;
  emit_rows(e, ((const solve *)state)->in.cloud.posted, cloud->n, cloud->dim);
}

static void write_norms(emit *e, const task *t, const void *state) {
  (void)t;
  emit_norms(e, &((const solve *)state)->norms);
}

static void write_diagnostics(emit *e, const task *t, const void *state) {
  (void)t;
  diagnostics_write(e, &((const solve *)state)->diagnostics);
}

static void write_history(emit *e, const task *t, const void *state) {
  const solve *s = state;
  (void)t;
  emit_object(e);
  member_doubles(e, "t", s->saved_time, s->saved);
  emit_key(e, "solution");
  emit_rows(e, s->saved_solution, s->saved, (int)s->in.cloud.cloud.n);
  if (s->in.exact.value) {
    member_doubles(e, "l2", s->saved_l2, s->saved);
    member_doubles(e, "linf", s->saved_linf, s->saved);
  }
  member_integer(e, "steps", s->march.steps);
  emit_end(e);
}

const process process_solve = {
    .id = "solve",
    .inputs = solve_inputs,
    .state_size = sizeof(solve),
    .read = read_solve,
    .run = run_solve,
    .clear = solve_clear,
    .memory = memory_of_solve,
    .alone = solve_alone,
    .coordinates = write_points,
    .outputs = {{"solution", NULL, false, write_solution, OUTPUT_FIELD},
                {"points", NULL, false, write_points, OUTPUT_COORDINATES},
                {"norms", "exact", true, write_norms},
                {"diagnostics", NULL, true, write_diagnostics},
                {"history", "time", true, write_history},
                {"report", NULL, true, report_write}},
};
