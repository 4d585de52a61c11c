#include "derivative.h"

#include <string.h>

#include "parameter_slope.h"
#include "scatter/adjoint.h"

typedef struct {
  task *t;
  solve *s;
  int64_t n;
  int dim;
  int64_t count; /* of parameters */
  parameter_slope *parameter;
  sct_tape tape;    /* of a march */
  sct_slope *slope; /* at the time of the system; NULL: none yet */
  sct_csr *rows;    /* Q of the output */
  sct_data data;    /* gradient of a level, or the change along vec */
  /* gradient */
  const double *q;  /* [n] dq/dphi at the end; NULL once its Dirichlet part is taken in */
  double *gradient; /* [count] out */
  /* tangent */
  const double *vec; /* [count] */
} derivative;

bool derivative_is_possible(const model *m) {
  static const char *const smooth[] = {"none", "exact", "cosine", "published"};
  const char *upwind = sct_upwind_name(m->solve.in.op.upwind);
  for (size_t k = 0; k < sizeof smooth / sizeof *smooth; k++) {
    if (!strcmp(upwind, smooth[k])) return true;
  }
  return false;
}

/* ---- Begin and end ---- */

static bool any(const derivative *d, bool (*has)(const parameter_slope *)) {
  for (int64_t k = 0; k < d->count; k++) {
    if (has(&d->parameter[k])) return true;
  }
  return false;
}

/* Slopes of the parameters at a time: all of them at first, then those that vary. */
static bool take_parameters(derivative *d, double time) {
  for (int64_t k = 0; k < d->count; k++) {
    parameter_slope *p = &d->parameter[k];
    if (p->taken && !p->varies) continue;
    if (!parameter_slope_take(d->t, &d->s->in, time, p)) return false;
  }
  return true;
}

static bool name_parameters(derivative *d, const model_inputs *in, int64_t vector) {
  const int64_t first = in->first[vector];
  d->count = in->first[vector + 1] - first;
  d->parameter = task_zeros(d->t, d->count, sizeof *d->parameter);
  for (int64_t k = 0; d->parameter && k < d->count; k++) {
    d->parameter[k].name = in->name[first + k];
    d->parameter[k].value = in->value[first + k];
  }
  return d->parameter != NULL;
}

/* Solves, and has ready what both directions need. */
static bool begin(task *t, model *m, int64_t out, int64_t in, derivative *d) {
  solve *s = &m->solve;
  *d = (derivative){.t = t, .s = s, .n = s->in.cloud.cloud.n, .dim = s->in.cloud.cloud.dim};
  if (!name_parameters(d, &m->in, in) || !take_parameters(d, s->in.march.start)) return false;
  if (!parameter_slope_zeros(t, d->parameter, d->count, d->n, d->dim, &d->data)) return false;
  d->tape.keeps_values = any(d, parameter_slope_weighs);
  d->tape.most_bytes = t->limits->memory_bytes / 2;
  if (s->in.is_transient) s->in.march.tape = &d->tape;
  const bool solved = !solve_compute(t, s);
  s->in.march.tape = NULL;
  return solved && functional_rows(t, &m->output[out], s, &d->rows);
}

static void end(derivative *d) {
  sct_tape_clear(&d->tape);
  sct_slope_free(&d->slope);
  sct_csr_free(&d->rows);
}

/* Brings all slopes to the time of the system. */
static sct_status bring(derivative *d, double time, sct_error *err) {
  const solve_input *in = &d->s->in;
  const sct_fields fields = solve_input_fields(in);
  if (!take_parameters(d, time)) {
    if (err != &d->t->error) *err = d->t->error;
    return d->t->error.code;
  }
  if (d->slope && !(solve_input_varies(in) & SCT_VARIES_MATRIX)) return SCT_OK;
  sct_slope_free(&d->slope);
  return sct_slope_build(d->s->grid.stencil, &fields, d->s->system, any(d, parameter_slope_moves),
                         &d->t->work, &d->slope, err);
}

static void zero(derivative *d) {
  for (int k = 0; k < DATA_MEMBERS; k++) {
    double *member = *data_member(&d->data, k);
    if (member) memset(member, 0, (size_t)(k == 0 ? d->n * d->dim : d->n) * sizeof *member);
  }
}

static sct_replay replay_of(const derivative *d, const sct_march_problem *in_time) {
  return (sct_replay){&d->tape, &d->s->in.march, &d->s->system, in_time, &d->t->work};
}

static sct_march_problem problem_of(const derivative *d, solve_context *context) {
  return (sct_march_problem){
      .varies = solve_input_varies(&d->s->in), .context = context, .advance = solve_advance};
}

/* ---- Gradient ---- */

/* dq/d(Dirichlet value), where the output is taken of one. */
static void take_direct_part(derivative *d) {
  for (int64_t i = 0; d->data.value && i < d->n; i++) {
    if (d->s->system->row_of[i] < 0) d->data.value[i] += d->q[i];
  }
  d->q = NULL;
}

static sct_status absorb(void *of, double time, const double *phi, const double *kappa,
                         sct_error *err) {
  derivative *d = of;
  const sct_status status = bring(d, time, err);
  if (status) return status;
  zero(d);
  sct_slope_apply_transposed(d->slope, d->s->system, -1, kappa, phi, &d->data);
  if (d->q) take_direct_part(d); /* the last level comes first */
  for (int64_t k = 0; k < d->count; k++) {
    d->gradient[k] += parameter_slope_dot(&d->parameter[k], &d->data, d->n, d->dim);
  }
  return SCT_OK;
}

static sct_status adjoint_steady(derivative *d, const double *q, sct_error *err) {
  const sct_system *system = d->s->system;
  double *y = task_take(d->t, system->unknowns, sizeof *y);
  double *lambda = task_take(d->t, system->unknowns, sizeof *lambda);
  if (!y || !lambda) return d->t->error.code;
  for (int64_t r = 0; r < system->unknowns; r++) y[r] = q[system->point_of[r]];
  const sct_status status = sct_solver_solve(d->s->solver, y, true, lambda, err);
  return status ? status : absorb(d, 0, d->s->phi, lambda, err);
}

static sct_status adjoint_in_time(derivative *d, double *q, sct_error *err) {
  solve_context context = {d->t, d->s};
  const sct_march_problem in_time = problem_of(d, &context);
  const sct_replay replay = replay_of(d, &in_time);
  double *y = task_take(d->t, d->n, sizeof *y); /* becomes dq/d(initial) */
  if (!y) return d->t->error.code;
  memcpy(y, q, (size_t)d->n * sizeof *y);
  const sct_status status = sct_march_adjoint(&replay, absorb, d, y, err);
  for (int64_t k = 0; !status && k < d->count; k++) {
    const double *initial = d->parameter[k].initial;
    for (int64_t i = 0; initial && i < d->n; i++) d->gradient[k] += y[i] * initial[i];
  }
  return status;
}

bool derivative_gradient(task *t, model *m, int64_t out, int64_t in, const double *sens,
                         double *gradient) {
  derivative d;
  bool good = begin(t, m, out, in, &d);
  double *q = good ? task_zeros(t, d.n, sizeof *q) : NULL;
  if (q) {
    d.q = q;
    d.gradient = gradient;
    sct_csr_multiply_transposed_add(d.rows, 1, sens, q);
    memset(gradient, 0, (size_t)d.count * sizeof *gradient);
    good = !(d.s->in.is_transient ? adjoint_in_time(&d, q, &t->error)
                                  : adjoint_steady(&d, q, &t->error));
  }
  end(&d);
  return q && good;
}

/* ---- Tangent ---- */

/* The change of the data along vec, at the time of the parameters' slopes. */
static void add_up(derivative *d) {
  zero(d);
  for (int64_t k = 0; k < d->count; k++) {
    parameter_slope_add(&d->parameter[k], d->vec[k], d->n, d->dim, &d->data);
  }
}

static sct_status slope_along(void *of, double time, const double *phi, double *r, sct_error *err) {
  derivative *d = of;
  const sct_status status = bring(d, time, err);
  if (status) return status;
  add_up(d);
  sct_slope_apply(d->slope, d->s->system, &d->data, phi, r);
  return SCT_OK;
}

static sct_status tangent_steady(derivative *d, double *change, sct_error *err) {
  const sct_system *system = d->s->system;
  double *r = task_take(d->t, system->unknowns, sizeof *r);
  double *x = task_take(d->t, system->unknowns, sizeof *x);
  if (!r || !x) return d->t->error.code;
  sct_status status = slope_along(d, 0, d->s->phi, r, err);
  if (!status) status = sct_solver_solve(d->s->solver, r, false, x, err);
  for (int64_t i = 0; !status && i < system->unknowns; i++) change[system->point_of[i]] = -x[i];
  return status;
}

static sct_status tangent_in_time(derivative *d, double *change, sct_error *err) {
  solve_context context = {d->t, d->s};
  const sct_march_problem in_time = problem_of(d, &context);
  const sct_replay replay = replay_of(d, &in_time);
  for (int64_t k = 0; k < d->count; k++) {
    const double *initial = d->parameter[k].initial;
    for (int64_t i = 0; initial && i < d->n; i++) change[i] += d->vec[k] * initial[i];
  }
  return sct_march_tangent(&replay, slope_along, d, change, err);
}

/* Dirichlet points change as their values do, those of the last level. */
static void set_dirichlet_part(const derivative *d, double *change) {
  for (int64_t i = 0; i < d->n; i++) {
    if (d->s->system->row_of[i] < 0) change[i] = d->data.value ? d->data.value[i] : 0;
  }
}

bool derivative_apply(task *t, model *m, int64_t out, int64_t in, const double *vec,
                      double *change) {
  derivative d;
  bool good = begin(t, m, out, in, &d);
  double *of_phi = good ? task_zeros(t, d.n, sizeof *of_phi) : NULL;
  if (of_phi) {
    d.vec = vec;
    good = !(d.s->in.is_transient ? tangent_in_time(&d, of_phi, &t->error)
                                  : tangent_steady(&d, of_phi, &t->error));
    set_dirichlet_part(&d, of_phi);
    sct_csr_multiply(d.rows, of_phi, change);
  }
  end(&d);
  return of_phi && good;
}
