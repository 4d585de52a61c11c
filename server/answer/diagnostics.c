#include "diagnostics.h"

#include <math.h>

#include "member.h"

/* A point whose M is worse than this has neighbours that hardly span the space. */
static const double DEGENERATE = 1e4;

static int entries_of(int dim) {
  return dim * (dim + 1) / 2;
}

bool diagnosis_take(task *t, const cloud_input *c, sct_diagnosis *all) {
  int64_t n = c->cloud.n;
  int dim = c->cloud.dim;
  all->neighbours = task_take(t, n, sizeof *all->neighbours);
  all->number_density = task_take(t, n, sizeof *all->number_density);
  all->artificial_velocity = task_take(t, n * dim, sizeof *all->artificial_velocity);
  all->effective_diffusivity = task_take(t, n * entries_of(dim), sizeof(double));
  all->condition = task_take(t, n, sizeof *all->condition);
  return t->error.code == SCT_OK;
}

static sct_range range_of_counts(const int32_t *value, int64_t n) {
  sct_range counts = {.min = INFINITY, .max = -INFINITY, .points = n};
  double sum = 0;
  for (int64_t i = 0; i < n; i++) {
    counts.min = fmin(counts.min, value[i]);
    counts.max = fmax(counts.max, value[i]);
    sum += value[i];
  }
  counts.mean = sum / (double)n;
  return counts;
}

static void velocity_part(const double *velocity, int64_t n, const uint8_t *mask,
                          diagnostics *out) {
  int dim = out->dim;
  for (int a = 0; a < dim; a++) {
    out->velocity_rms[a] = sct_range_of(velocity + a, n, dim, mask).rms;
  }
  for (int64_t i = 0; i < n; i++) {
    double square = 0;
    for (int a = 0; a < dim; a++) square += velocity[i * dim + a] * velocity[i * dim + a];
    if (!mask || mask[i]) out->velocity_max = fmax(out->velocity_max, sqrt(square));
  }
}

/* Mean of entry k, and its root mean square distance from the unit tensor's. */
static void entry_part(const double *tensor, int64_t n, int k, const uint8_t *mask,
                       diagnostics *out) {
  const double unit = k < out->dim;
  const int entries = entries_of(out->dim);
  double squares = 0, points = 0;
  for (int64_t i = 0; i < n; i++) {
    if (mask && !mask[i]) continue;
    double off = tensor[i * entries + k] - unit;
    squares += off * off;
    points++;
  }
  out->tensor_mean[k] = sct_range_of(tensor + k, n, entries, mask).mean;
  out->tensor_deviation[k] = sqrt(squares / points);
}

static void tensor_part(const double *tensor, int64_t n, const uint8_t *mask, diagnostics *out) {
  for (int k = 0; k < entries_of(out->dim); k++) entry_part(tensor, n, k, mask, out);
}

static void deficient_part(const cloud_input *c, const sct_diagnosis *all, diagnostics *out) {
  for (int64_t i = 0; i < c->cloud.n; i++) {
    bool is_enough = all->neighbours[i] > out->dim && all->condition[i] < DEGENERATE;
    if (is_enough) continue;
    if (out->deficient < DEFICIENT_MAX) out->deficient_points[out->deficient] = c->order[i];
    out->deficient++;
  }
}

sct_status diagnostics_of_cloud(task *t, const cloud_input *c, const discretisation *d,
                                const sct_diagnosis *all, const uint8_t *mask, diagnostics *out) {
  int64_t n = c->cloud.n;
  *out = (diagnostics){.dim = c->cloud.dim, .h = d->spacing, .peclet_mean = NAN, .peclet_max = NAN};
  if (sct_diagnose(d->stencil, &t->work, all, &t->error)) return t->error.code;
  if (sct_median(d->nearest, n, &out->median, &t->error)) return t->error.code;
  out->spacing = sct_range_of(d->nearest, n, 1, NULL);
  out->neighbours = range_of_counts(all->neighbours, n);
  velocity_part(all->artificial_velocity, n, mask, out);
  tensor_part(all->effective_diffusivity, n, mask, out);
  deficient_part(c, all, out);
  return SCT_OK;
}

void diagnostics_of_rows(const uint8_t *flags, int64_t n, diagnostics *out) {
  out->has_rows = true;
  for (int64_t i = 0; i < n; i++) {
    out->widened += (flags[i] & SCT_ROW_WIDENED) != 0;
    out->fallback += (flags[i] & SCT_ROW_FALLBACK) != 0;
  }
}

void diagnostics_of_fields(const double *velocity, const double *diffusivity, int64_t n,
                           const uint8_t *mask, diagnostics *out) {
  double sum = 0, largest = 0, points = 0;
  for (int64_t i = 0; i < n; i++) {
    double speed = 0;
    if (mask && !mask[i]) continue;
    for (int a = 0; velocity && a < out->dim; a++) {
      speed = hypot(speed, velocity[i * out->dim + a]);
    }
    double peclet = speed > 0 ? speed * out->h / diffusivity[i] : 0;
    sum += peclet;
    largest = fmax(largest, peclet);
    points++;
  }
  out->peclet_mean = sum / points;
  out->peclet_max = largest;
}

void diagnostics_of_system(const sct_system *system, diagnostics *out) {
  out->is_solve = true;
  out->is_limited = system->limited != NULL;
  out->rows = system->unknowns;
  out->nonzeros = sct_csr_entries(system->matrix);
  out->widened = system->widened;
  out->fallback = system->fallback;
  out->loose = system->loose;
}

/* Writing */

static void write_extent(emit *e, const char *key, double min, const char *middle_key,
                         double middle, double max) {
  member_object(e, key);
  member_number(e, "min", min);
  if (middle_key) member_number(e, middle_key, middle);
  member_number(e, "max", max);
  emit_end(e);
}

static void write_velocity(emit *e, const diagnostics *d) {
  double reynolds[SCT_DIM_MAX];
  for (int a = 0; a < d->dim; a++) reynolds[a] = d->velocity_rms[a] * d->h;
  member_object(e, "artificial_velocity");
  member_doubles(e, "rms", d->velocity_rms, d->dim);
  member_number(e, "max", d->velocity_max);
  emit_end(e);
  member_doubles(e, "cell_reynolds", reynolds, d->dim);
}

static void write_tensor(emit *e, const diagnostics *d) {
  member_object(e, "effective_diffusivity");
  member_doubles(e, "mean", d->tensor_mean, entries_of(d->dim));
  member_doubles(e, "rms_deviation", d->tensor_deviation, entries_of(d->dim));
  emit_end(e);
}

static void write_deficient(emit *e, const diagnostics *d) {
  int64_t listed = d->deficient < DEFICIENT_MAX ? d->deficient : DEFICIENT_MAX;
  member_object(e, "deficient");
  member_integer(e, "count", d->deficient);
  emit_key(e, "points");
  emit_int32s(e, d->deficient_points, 1, &listed);
  emit_end(e);
}

static void write_peclet(emit *e, const diagnostics *d) {
  if (!isfinite(d->peclet_mean)) return;
  member_object(e, "cell_peclet");
  member_number(e, "mean", d->peclet_mean);
  member_number(e, "max", d->peclet_max);
  emit_end(e);
}

/* The defect correction of upwind limited. */
static void write_correction(emit *e, const diagnostics *d) {
  const sct_limited_report *r = &d->march.limited;
  int64_t kept = r->iterations < SCT_LIMITED_HISTORY ? r->iterations : SCT_LIMITED_HISTORY;
  member_integer(e, "iterations", r->iterations);
  member_number(e, "residual", r->residual);
  member_doubles(e, "residual_history", r->history, kept);
  if (!d->is_transient) return;
  member_integer(e, "iterations_most", r->most);
  member_integer(e, "iterations_total", r->total);
}

/* What an iterative method tells, or told before a direct one took over. */
static void write_iteration(emit *e, const sct_solve_report *solve) {
  if (!solve->krylov) return;
  member_text(e, "krylov", solve->krylov);
  member_text(e, "preconditioner", solve->preconditioner);
  member_number(e, "relative_residual", solve->relative_residual);
  member_object(e, "history");
  member_integer(e, "every", solve->history_every);
  member_doubles(e, "residual", solve->history, solve->history_count);
  emit_end(e);
  if (solve->fallback[0] != '\0') member_text(e, "fallback", solve->fallback);
}

static void write_solver(emit *e, const diagnostics *d) {
  const sct_solve_report *solve = &d->solve;
  if (!solve->method) return;
  member_object(e, "solver");
  member_text(e, "method", solve->method);
  member_text(e, "ordering", solve->ordering);
  if (d->is_limited) {
    write_correction(e, d);
  } else {
    member_integer(e, "iterations", solve->iterations);
    member_number(e, "residual", solve->residual);
  }
  if (solve->reciprocal_condition > 0) {
    member_number(e, "reciprocal_condition", solve->reciprocal_condition);
  }
  if (solve->factor_nonzeros > 0) member_integer(e, "factor_nonzeros", solve->factor_nonzeros);
  if (solve->peak_bytes > 0) member_integer(e, "peak_bytes", solve->peak_bytes);
  write_iteration(e, solve);
  emit_end(e);
}

static void write_march(emit *e, const sct_march_report *march) {
  member_integer(e, "steps", march->steps);
  member_number(e, "step", march->step);
  if (march->stable_step > 0) member_number(e, "stable_step", march->stable_step);
  member_integer(e, "factorisations", march->factorisations);
}

static void write_rows(emit *e, int64_t widened, int64_t fallback) {
  member_integer(e, "widened", widened);
  member_integer(e, "fallback", fallback);
}

static void write_system(emit *e, const diagnostics *d) {
  write_peclet(e, d);
  write_extent(e, "bounds", d->bounds.min, NULL, 0, d->bounds.max);
  member_object(e, "matrix");
  member_integer(e, "rows", d->rows);
  member_integer(e, "nonzeros", d->nonzeros);
  emit_end(e);
  write_rows(e, d->widened, d->fallback);
  member_integer(e, "loose", d->loose);
  write_solver(e, d);
  if (d->is_transient) write_march(e, &d->march);
}

void diagnostics_write(emit *e, const diagnostics *d) {
  emit_object(e);
  write_extent(e, "spacing", d->spacing.min, "median", d->median, d->spacing.max);
  write_extent(e, "neighbours", d->neighbours.min, "mean", d->neighbours.mean, d->neighbours.max);
  write_velocity(e, d);
  write_tensor(e, d);
  write_deficient(e, d);
  if (d->has_rows) write_rows(e, d->widened, d->fallback);
  if (d->is_solve) write_system(e, d);
  emit_end(e);
}

void emit_norms(emit *e, const sct_norms *norms) {
  emit_object(e);
  member_number(e, "l1", norms->l1);
  member_number(e, "l2", norms->l2);
  member_number(e, "linf", norms->linf);
  member_number(e, "l2_relative", norms->l2_relative);
  member_number(e, "linf_all", norms->linf_all);
  member_integer(e, "points", norms->points);
  emit_end(e);
}
