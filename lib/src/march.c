/* The march: from stop to stop (save times, end), step by step, the same for every scheme; what
 * differs are the weights (march_scheme.h) and the rows that need a solve (march_matrix.h). */
#include "scatter/march.h"

#include <math.h>
#include <string.h>

#include "alloc.h"
#include "limited_iterate.h"
#include "march_growth.h"
#include "march_matrix.h"
#include "march_plan.h"
#include "march_scheme.h"
#include "march_tape.h"

typedef struct {
  sct_system **system;
  const sct_march_options *options;
  const sct_march_problem *problem;
  const sct_work *work;
  sct_march_report *report;
  double *phi;             /* [n] at time t */
  double *y;               /* [unknowns] the unknowns of phi */
  double *before;          /* [unknowns] one step earlier */
  double *rhs;             /* [unknowns] of (1) in march_scheme.h */
  double *load;            /* [unknowns] b */
  double t;                /* time reached */
  double dt;               /* longest step allowed */
  double last;             /* last step taken, 0: none */
  sct_solve_options solve; /* of the options, refinement off below 1e-14 */
  double factored;         /* shift of the factored matrix, NaN: none */
  double steps;            /* planned */
  sct_march_matrix *matrix;
  sct_march_growth growth;
  sct_limited_iteration *limited; /* NULL: steps are linear */
} marcher;

/* Backward error of a step's solve: some roundings more than the best, for half the price; steps do
 * not add them up, the schemes damp. */
static const double step_tolerance = 1e-14;

double sct_march_stable_step(const sct_system *system, int64_t *point) {
  const sct_csr *const parts[] = {system->matrix, system->coupling};
  double largest = 0;
  if (point != NULL) *point = -1;
  for (int64_t i = 0; i < system->unknowns; i++) {
    double reach = 0; /* a_ii + sum_j |a_ij|: rightmost point of Gershgorin's disc */
    if (!system->is_equation[i]) continue;
    for (int p = 0; p < 2; p++) {
      for (int64_t k = parts[p]->start[i]; k < parts[p]->start[i + 1]; k++) {
        const double v = parts[p]->value[k];
        reach += p == 0 && parts[p]->column[k] == i ? v : fabs(v);
      }
    }
    reach += sct_limited_reach(system, i);
    if (reach > largest) {
      largest = reach;
      if (point != NULL) *point = system->point_of[i];
    }
  }
  return 2 / largest;
}

static bool is_explicit(const marcher *m) {
  return m->options->method == SCT_FORWARD_EULER;
}

static bool varies(const marcher *m, int what) {
  return m->problem != NULL && (m->problem->varies & what) != 0;
}

/* -- one step ------------------------------------------------------------------------------ */

static sct_status check_stable(marcher *m, sct_error *err) {
  int64_t point;
  if (!is_explicit(m)) return SCT_OK;
  const double stable = sct_march_stable_step(*m->system, &point);
  m->report->stable_step = fmin(m->report->stable_step, stable);
  if (m->dt <= stable * (1 + 1e-9)) return SCT_OK;
  return sct_fail(
      err, SCT_E_UNSTABLE, point,
      "gets forward Euler steps of %.6g, needs at most %.6g at t = %.9g; take a smaller "
      "step or an implicit scheme",
      m->dt, stable, m->t);
}

/* Brings system and Dirichlet values to time t, and what is known about them. */
static sct_status advance(marcher *m, double t, sct_error *err) {
  if (!varies(m, ~0)) return SCT_OK;
  const int64_t n = (*m->system)->n, unknowns = (*m->system)->unknowns;
  sct_status status = m->problem->advance(m->problem->context, t, m->system, m->phi, err);
  if (status != SCT_OK) return status;
  if ((*m->system)->n != n || (*m->system)->unknowns != unknowns) {
    return sct_fail(err, SCT_E_ARGUMENT, -1, "the system changed size at t = %.9g", t);
  }
  if (m->growth.lift == NULL) return SCT_OK; /* at the start: taken in right after */
  if (varies(m, SCT_VARIES_MATRIX)) {
    m->factored = NAN;
    status = sct_march_growth_matrix(&m->growth, *m->system, err);
    if (status == SCT_OK) status = check_stable(m, err);
  }
  if (status == SCT_OK && varies(m, SCT_VARIES_MATRIX | SCT_VARIES_LOAD)) {
    status = sct_march_growth_load(&m->growth, *m->system, err);
  }
  return status;
}

/* load = load + q(y) */
static void add_correction(marcher *m) {
  const sct_system *system = *m->system;
  const double *q = sct_limited_iteration_correction(m->limited, system, m->phi, m->y, m->work);
  for (int64_t i = 0; i < system->unknowns; i++) m->load[i] += q[i];
}

/* What the old time gives: rhs = now y + before y'' + explicit dt (b - A y). */
static void old_part(marcher *m, sct_march_weights w, double dt) {
  const sct_system *system = *m->system;
  if (w.explicit != 0) {
    sct_system_rhs(system, m->phi, m->load);
    sct_csr_multiply_add_by(system->matrix, -1, m->y, m->load, sct_work_threads(m->work));
    if (m->limited != NULL) add_correction(m);
  }
  for (int64_t i = 0; i < system->unknowns; i++) {
    m->rhs[i] = w.now * m->y[i];
    if (w.before != 0) m->rhs[i] += w.before * m->before[i];
    if (w.explicit != 0) m->rhs[i] += w.explicit * dt * m->load[i];
  }
}

/* What the new time gives: rhs = rhs + implicit dt b'; condition rows b'. */
static void new_part(marcher *m, sct_march_weights w, double dt) {
  const sct_system *system = *m->system;
  sct_system_rhs(system, m->phi, m->load);
  for (int64_t i = 0; i < system->unknowns; i++) {
    m->rhs[i] = system->is_equation[i] ? m->rhs[i] + w.implicit * dt * m->load[i] : m->load[i];
  }
}

static sct_status factor(marcher *m, double shift, sct_error *err) {
  if (m->factored == shift) return SCT_OK;
  sct_status status = sct_march_matrix_factor(m->matrix, *m->system, shift, &m->solve, err);
  m->factored = status == SCT_OK ? shift : NAN;
  return status;
}

/* Factors of the step, or of the conditions among themselves, at the iteration's disposal. */
typedef struct {
  sct_march_matrix *matrix;
  const sct_system *system;
} factors;

static sct_status substitute(void *context, const double *r, double *x, sct_error *err) {
  const factors *f = context;
  return sct_march_matrix_solve(f->matrix, f->system, r, x, err);
}

/* The conditions of an explicit scheme are linear unless a weight of theirs has to be cut off. */
static bool is_linear(const marcher *m, double shift) {
  const sct_system *system = *m->system;
  bool bound = shift != 0;
  for (int64_t i = 0; !bound && i < system->unknowns; i++) {
    bound = !system->is_equation[i] && sct_limited_reach(system, i) > 0;
  }
  return m->limited == NULL || !bound;
}

/* y from rhs: the unknowns of a step of `shift`, from `start` where they have to be iterated. */
static sct_status solve_rows(marcher *m, sct_march_matrix *matrix, double shift,
                             const double *start, sct_error *err) {
  factors f = {matrix, *m->system};
  if (is_linear(m, shift)) return sct_march_matrix_solve(matrix, f.system, m->rhs, m->y, err);
  const sct_limited_equation equation = {.system = f.system,
                                         .own = 1,
                                         .shift = shift,
                                         .rhs = m->rhs,
                                         .solve = substitute,
                                         .context = &f};
  memmove(m->y, start, (size_t)f.system->unknowns * sizeof *start);
  return sct_limited_iterate(m->limited, &equation, &m->options->limited, m->work, NULL, m->phi,
                             m->y, &m->report->limited, err);
}

static void scatter(const marcher *m) {
  const sct_system *system = *m->system;
  for (int64_t i = 0; i < system->unknowns; i++) m->phi[system->point_of[i]] = m->y[i];
}

static void gather(const marcher *m) {
  const sct_system *system = *m->system;
  for (int64_t i = 0; i < system->unknowns; i++) m->y[i] = m->phi[system->point_of[i]];
}

/* What to do about phi that grows: implicit schemes damp whatever the operator damps. */
static const char *advice(const marcher *m) {
  return is_explicit(m)
             ? "the step is not stable: take a smaller one, upwinding or an implicit scheme"
             : "the operator feeds it: take upwinding, a smoother cloud or another scheme";
}

/* Where y is heading, from y at hand and before it: what iterative solvers start from. */
static void extrapolate(const marcher *m, double dt) {
  const double ahead = m->last > 0 ? dt / m->last : 0;
  const int64_t unknowns = (*m->system)->unknowns;
  for (int64_t i = 0; i < unknowns; i++) {
    m->y[i] = ahead > 0 ? m->before[i] + ahead * (m->before[i] - m->y[i]) : m->before[i];
  }
}

static sct_status step(marcher *m, double t, double dt, sct_error *err) {
  const sct_march_weights w = sct_march_weigh(m->options->method, m->last == 0 ? 0 : dt / m->last);
  old_part(m, w, dt);
  double *oldest = m->before;
  m->before = m->y;
  m->y = oldest;
  extrapolate(m, dt);
  sct_status status = advance(m, t, err);
  if (status != SCT_OK) return status;
  new_part(m, w, dt);
  status = factor(m, w.implicit * dt, err);
  if (status != SCT_OK) return status;
  status = solve_rows(m, m->matrix, w.implicit * dt, m->before, err);
  if (status != SCT_OK) return status;
  scatter(m);
  m->t = t;
  m->last = dt;
  m->report->steps++;
  m->report->step = fmax(m->report->step, dt);
  sct_tape_record(m->options->tape, *m->system, t, dt, m->phi, m->y);
  return sct_march_growth_check(&m->growth, *m->system, m->phi, t, dt, advice(m), err);
}

/* -- from stop to stop --------------------------------------------------------------------- */

/* The even step; the last one again if only rounding differs, so that its factors serve. */
static double even_step(const marcher *m, double length, double steps) {
  const double dt = length / steps;
  return fabs(dt - m->last) <= 1e-11 * dt ? m->last : dt;
}

static sct_status run_to(marcher *m, double stop_time, sct_error *err) {
  const double from = m->t, steps = sct_march_steps_over(stop_time - from, m->dt);
  const double dt = is_explicit(m) ? m->dt : even_step(m, stop_time - from, steps);
  for (double k = 1; k <= steps; k++) {
    const bool shortened = is_explicit(m) && k == steps;
    sct_status status =
        step(m, k == steps ? stop_time : from + k * dt, shortened ? stop_time - m->t : dt, err);
    if (status != SCT_OK) return status;
    status = sct_work_report(m->work, "march", (double)m->report->steps / m->steps, err);
    if (status != SCT_OK) return status;
  }
  return SCT_OK;
}

static sct_status save(const marcher *m, sct_error *err) {
  if (m->problem == NULL || m->problem->save == NULL) return SCT_OK;
  return m->problem->save(m->problem->context, m->t, m->phi, err);
}

static sct_status run(marcher *m, sct_error *err) {
  for (int64_t k = 0; k < sct_march_stops(m->options); k++) {
    sct_status status = run_to(m, sct_march_stop(m->options, k), err);
    if (status == SCT_OK) status = save(m, err);
    if (status != SCT_OK) return status;
  }
  return SCT_OK;
}

/* -- begin and end ------------------------------------------------------------------------- */

static sct_status allocate(marcher *m, sct_error *err) {
  const int64_t unknowns = (*m->system)->unknowns;
  double **const arrays[] = {&m->y, &m->before, &m->rhs, &m->load};
  for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++) {
    sct_status status = sct_alloc(arrays[k], unknowns, sizeof(double), err);
    if (status != SCT_OK) return status;
  }
  if ((*m->system)->limited != NULL) {
    sct_status status = sct_limited_iteration_new(*m->system, &m->limited, err);
    if (status != SCT_OK) return status;
    sct_limited_relax(&m->solve);
  }
  return sct_march_matrix_new(*m->system, is_explicit(m), &m->matrix, err);
}

/* Condition rows of the initial values: what they hand to a rate at the old time must be what the
 * conditions say, or a flux is late by a part of the first step. phi itself stays as given. */
static sct_status settle(marcher *m, sct_march_matrix *conditions, sct_error *err) {
  memcpy(m->rhs, m->y, (size_t)(*m->system)->unknowns * sizeof *m->rhs);
  new_part(m, (sct_march_weights){0}, 0);
  sct_status status = sct_march_matrix_factor(conditions, *m->system, 0, &m->solve, err);
  if (status == SCT_E_SINGULAR && !is_explicit(m)) {
    if (m->options->tape != NULL) m->options->tape->is_settled = false;
    return SCT_OK; /* solved with the others only */
  }
  if (status == SCT_E_SINGULAR) {
    return sct_fail(err, status, -1,
                    "the condition rows are singular among themselves, which forward Euler solves "
                    "alone; take an implicit scheme");
  }
  if (status != SCT_OK) return status;
  return solve_rows(m, conditions, 0, m->y, err);
}

static sct_status settle_for_rate(marcher *m, sct_error *err) {
  if (!sct_march_uses_old_rate(m->options->method)) return SCT_OK;
  if (is_explicit(m)) {
    sct_status status = settle(m, m->matrix, err);
    if (status == SCT_OK) m->factored = 0;
    return status;
  }
  sct_march_matrix *conditions;
  sct_status status = sct_march_matrix_new(*m->system, true, &conditions, err);
  if (status == SCT_OK) status = settle(m, conditions, err);
  sct_march_matrix_free(&conditions);
  return status;
}

static sct_status plan(marcher *m, sct_error *err) {
  const sct_march_options *o = m->options;
  if (o->step == 0 || is_explicit(m)) {
    m->report->stable_step = sct_march_stable_step(*m->system, NULL);
  }
  m->dt = o->step > 0 ? o->step : o->diffusion_number * m->report->stable_step;
  m->dt = fmin(m->dt, o->end - o->start);
  return sct_march_plan_count(o, m->dt, &m->steps, err);
}

static sct_status begin(marcher *m, sct_error *err) {
  m->t = m->options->start;
  m->factored = NAN;
  m->solve = m->options->solve;
  m->solve.backward_error = fmax(m->solve.backward_error, step_tolerance);
  sct_status status = advance(m, m->t, err);
  if (status == SCT_OK) status = allocate(m, err);
  if (status == SCT_OK) status = sct_march_growth_new(*m->system, m->phi, &m->growth, err);
  if (status == SCT_OK) status = plan(m, err);
  if (status == SCT_OK) status = check_stable(m, err);
  if (status == SCT_OK) status = sct_work_report(m->work, "march", 0, err);
  if (status != SCT_OK) return status;
  gather(m);
  status = sct_tape_start(m->options->tape, m->options->method, *m->system, m->steps, err);
  if (status == SCT_OK) status = settle_for_rate(m, err);
  if (status == SCT_OK) sct_tape_record(m->options->tape, *m->system, m->t, 0, m->phi, m->y);
  return status;
}

static void end(marcher *m) {
  if (m->matrix != NULL) {
    const sct_solve_report *solve = sct_march_matrix_report(m->matrix);
    if (solve != NULL) m->report->solve = *solve;
    m->report->factorisations = sct_march_matrix_factorisations(m->matrix);
  }
  sct_march_matrix_free(&m->matrix);
  sct_march_growth_free(&m->growth);
  sct_limited_iteration_free(&m->limited);
  sct_release(&m->y);
  sct_release(&m->before);
  sct_release(&m->rhs);
  sct_release(&m->load);
}

sct_status sct_march(sct_system **system, const sct_march_options *options,
                     const sct_march_problem *problem, const sct_work *work, double *phi,
                     sct_march_report *report, sct_error *err) {
  sct_march_report unread = {0};
  marcher m = {.system = system,
               .options = options,
               .problem = problem,
               .work = work,
               .phi = phi,
               .report = report != NULL ? report : &unread};
  *m.report = (sct_march_report){0};
  sct_status status = sct_march_plan_check(options, err);
  if (status == SCT_OK) status = begin(&m, err);
  if (status == SCT_OK) status = run(&m, err);
  end(&m);
  return status;
}
