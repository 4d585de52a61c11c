/* flow.c - a flow from its building to its end: the order of things. */
#include "scatter/flow.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "alloc.h"
#include "flow_domain.h"
#include "flow_inside.h"
#include "flow_view.h"

/* Steps between two looks at the number of particles. */
enum { CONTROL_EVERY = 5 };

/* Velocities this many times those of boundary and start are no flow. */
static const double RUNAWAY = 1e3;

#define SCT_FLOW_TEXT(symbol, name) name,
static const char *const kinds[] = {SCT_FLOW_SIDE_LIST(SCT_FLOW_TEXT)};
static const char *const walls[] = {SCT_FLOW_WALLS_LIST(SCT_FLOW_TEXT)};
#undef SCT_FLOW_TEXT

const char *sct_flow_kind_name(sct_flow_kind kind) {
  return (unsigned)kind < SCT_FLOW_SIDE_COUNT ? kinds[kind] : NULL;
}

const char *sct_flow_walls_name(sct_flow_walls w) {
  return (unsigned)w < SCT_FLOW_WALLS_COUNT ? walls[w] : NULL;
}

sct_flow_options sct_flow_default(sct_scheme scheme, double viscosity, double end) {
  return (sct_flow_options){.viscosity = viscosity,
                            .op = sct_operator_default(scheme, 2),
                            .walls = SCT_FLOW_WALL_POINTS,
                            .courant = 0.25,
                            .diffusion_number = 0.8,
                            .shift = 0.25,
                            .end = end,
                            .average_from = 0.75 * end,
                            .samples = 200,
                            .max_particles = INT64_C(1) << 27};
}

/* ---- options ---- */

static sct_status check_operator(const sct_operator *op, sct_error *err) {
  sct_status status = sct_operator_check(op, err);
  if (status != SCT_OK) return status;
  if (op->scheme == SCT_MPS || op->upwind != SCT_UPWIND_NONE || op->density != SCT_DENSITY_LOCAL ||
      op->degree != 2 || op->weight != SCT_WEIGHT_KERNEL_R2 || op->radius > 3) {
    return sct_fail(err, SCT_E_ARGUMENT, -1,
                    "operator is not for a flow, needs ps, ips, ipsn or lsmps of degree 2 with "
                    "local density, weight kernel/r2, no upwinding and a radius up to 3");
  }
  return SCT_OK;
}

static sct_status check_numbers(const sct_flow_options *o, sct_error *err) {
  const struct {
    const char *name;
    double value, low, high;
    bool above;
  } rules[] = {{"viscosity", o->viscosity, 0, 1e100, true},
               {"courant", o->courant, 0, 1, true},
               {"diffusion number", o->diffusion_number, 0, 1, true},
               {"shift", o->shift, 0, 1, false},
               {"jitter", o->jitter, 0, 1, false},
               {"end", o->end, 0, 1e100, true},
               {"average_from", o->average_from, 0, o->end, false},
               {"samples", (double)o->samples, 1, 1e6, false},
               {"scalar's diffusivity", o->diffusivity, 0, 1e100, false}};
  for (size_t k = 0; k < sizeof rules / sizeof rules[0]; k++) {
    const double v = rules[k].value;
    if (v >= rules[k].low && v <= rules[k].high && !(rules[k].above && v == rules[k].low)) continue;
    return sct_fail(err, SCT_E_ARGUMENT, -1, "%s is %g, needs %s%g to %g", rules[k].name, v,
                    rules[k].above ? "above " : "", rules[k].low, rules[k].high);
  }
  return SCT_OK;
}

static sct_status check_options(const sct_flow_options *o, sct_error *err) {
  sct_status status = check_operator(&o->op, err);
  if (status == SCT_OK) status = check_numbers(o, err);
  if (status == SCT_OK && (unsigned)o->walls >= SCT_FLOW_WALLS_COUNT) {
    status = sct_fail(err, SCT_E_ARGUMENT, -1, "treatment %d of walls is unknown", (int)o->walls);
  }
  for (int64_t k = 0; k < o->saves && status == SCT_OK; k++) {
    const double before = k > 0 ? o->save[k - 1] : 0;
    if (o->save[k] > before && o->save[k] <= o->end) continue;
    status = sct_fail(err, SCT_E_ARGUMENT, -1,
                      "save time %" PRId64 " is %g, needs ascending times above 0 up to %g", k,
                      o->save[k], o->end);
  }
  return status;
}

/* ---- building ---- */

/* S_w and the stable step S_w / (4 sum w / r^2) on a lattice of spacing 1. */
static void lattice_sums(sct_flow *f) {
  const double support = f->options.op.radius;
  double w = 0, ww = 0;
  for (int b = -3; b <= 3; b++) {
    for (int a = -3; a <= 3; a++) {
      const double r2 = a * a + b * b, r = sqrt(r2);
      if (r2 == 0 || r >= support * (1 - 1e-10)) continue;
      const double weight = f->options.op.kernel->w(r / support);
      w += weight;
      ww += weight / r2;
    }
  }
  f->full = w;
  f->stable = w / (4 * ww);
}

static sct_status take_memory(sct_flow *f, sct_error *err) {
  const int64_t cells = f->mesh.cells;
  sct_status status = sct_alloc_zero(&f->sites.start, cells + 1, sizeof *f->sites.start, err);
  for (int a = 0; a < 2 && status == SCT_OK; a++) {
    const int64_t n = f->mesh.faces[a];
    status = sct_alloc_zero(&f->face[a], n, sizeof *f->face[a], err);
    if (status == SCT_OK) status = sct_alloc_zero(&f->change[a], n, sizeof *f->change[a], err);
    if (status == SCT_OK) status = sct_alloc_zero(&f->mean[a], n, sizeof *f->mean[a], err);
  }
  if (status == SCT_OK) status = sct_alloc_zero(&f->seed, 2 * cells, sizeof *f->seed, err);
  if (status == SCT_OK) status = sct_alloc_zero(&f->seeded, cells, sizeof *f->seeded, err);
  if (status == SCT_OK) {
    status = sct_alloc_zero(&f->mean_phi, f->unknowns, sizeof *f->mean_phi, err);
  }
  if (status == SCT_OK) { /* both ends are sampled, too */
    status = sct_alloc_zero(&f->history, f->options.samples + 2, sizeof *f->history, err);
  }
  if (status == SCT_OK) {
    status = sct_alloc_zero(&f->snapshot, f->options.saves, sizeof *f->snapshot, err);
  }
  return status;
}

/* One particle per fluid cell, at its centre but for the jitter. */
static sct_status place_particles(sct_flow *f, sct_error *err) {
  const flow_mesh *m = &f->mesh;
  const int64_t nx = m->axis[0].n;
  const sct_status status = flow_particles_reserve(f, m->fluids, err);
  if (status != SCT_OK) return status;
  for (int64_t c = 0; c < m->cells; c++) {
    if (!m->fluid[c]) continue;
    const int64_t cell[2] = {c % nx, c / nx};
    const int64_t p = f->particles.n++;
    double x[2], u[2];
    for (int a = 0; a < 2; a++) {
      const double chi = flow_random(f, 0, (uint64_t)(2 * p + a)) - 0.5;
      x[a] = m->axis[a].centre[cell[a]] + f->options.jitter * chi * m->axis[a].width[cell[a]];
      f->particles.x[a][p] = x[a];
    }
    flow_interpolate(m, f->change, cell[0], cell[1], x, u); /* grad phi, nearest at walls */
    for (int a = 0; a < 2; a++) f->particles.field[a][p] = u[a];
    if (f->options.has_scalar) f->particles.field[FLOW_C][p] = 0;
  }
  return SCT_OK;
}

static sct_status place_scalar(sct_flow *f, sct_error *err) {
  flow_particles *p = &f->particles;
  double *x = NULL;
  if (!f->options.has_scalar || f->options.initial == NULL) return SCT_OK;
  sct_status status = sct_alloc(&x, 2 * p->n, sizeof *x, err);
  if (status != SCT_OK) return status;
  for (int64_t k = 0; k < 2 * p->n; k++) x[k] = p->x[k % 2][k / 2];
  status = f->options.initial(f->options.context, p->n, x, p->field[FLOW_C], err);
  for (int64_t k = 0; k < p->n && status == SCT_OK; k++) {
    if (isfinite(p->field[FLOW_C][k])) continue;
    status = sct_fail(err, SCT_E_NOT_FINITE, -1, "the scalar at (%g, %g) is not finite", x[2 * k],
                      x[2 * k + 1]);
  }
  sct_release(&x);
  return status;
}

static void note_speed(sct_flow *f) {
  f->speed = 0;
  for (int64_t k = 0; k < f->mesh.bounds; k++) {
    const flow_bound *b = &f->mesh.bound[k];
    if (b->kind == FACE_OUTFLOW) continue;
    f->speed = fmax(f->speed, fmax(hypot(b->velocity[0], b->velocity[1]), fabs(b->mean)));
  }
  for (int64_t p = 0; p < f->particles.n; p++) {
    f->speed = fmax(f->speed, hypot(f->particles.field[0][p], f->particles.field[1][p]));
  }
}

static sct_status lay_out(sct_flow *f, const sct_flow_domain *domain, sct_error *err) {
  sct_status status = flow_mesh_build(domain, &f->mesh, err);
  if (status == SCT_OK) status = flow_domain_lay(domain, &f->mesh, err);
  if (status == SCT_OK) status = flow_walls_build(f, err);
  if (status == SCT_OK) status = flow_pressure_build(f, err);
  if (status == SCT_OK) status = take_memory(f, err);
  if (status != SCT_OK) return status;
  flow_prescribe(f); /* and nothing inside: what makes that free of divergence is potential flow */
  status = flow_project(f, err);
  if (status == SCT_OK) status = place_particles(f, err);
  if (status == SCT_OK) status = place_scalar(f, err);
  memset(f->phi, 0, (size_t)f->unknowns * sizeof *f->phi);
  f->controls = !f->mesh.is_uniform || f->inlets > 0;
  note_speed(f);
  return status;
}

/* A view is only read: its memory is there before, with some to spare. */
sct_status flow_reserve_views(sct_flow *f, sct_error *err) {
  const int64_t n = f->particles.n, room = n + n / 8;
  if (n <= f->view_capacity) return SCT_OK;
  f->view_capacity = 0;
  sct_status status = sct_realloc(&f->view_x, 2 * room, sizeof *f->view_x, err);
  if (status == SCT_OK) status = sct_realloc(&f->view_u, 2 * room, sizeof *f->view_u, err);
  if (status == SCT_OK && f->options.has_scalar) {
    status = sct_realloc(&f->view_c, room, sizeof *f->view_c, err);
  }
  if (status == SCT_OK) f->view_capacity = room;
  return status;
}

sct_status sct_flow_build(const sct_flow_domain *domain, const sct_flow_options *options,
                          sct_flow **out, sct_error *err) {
  sct_flow *f = NULL;
  *out = NULL;
  sct_status status = check_options(options, err);
  if (status == SCT_OK) status = sct_alloc_zero(&f, 1, sizeof *f, err);
  if (status != SCT_OK) return status;
  f->options = *options;
  lattice_sums(f);
  status = sct_alloc(&f->save, options->saves, sizeof *f->save, err);
  if (status == SCT_OK) {
    if (options->saves > 0)
      memcpy(f->save, options->save, (size_t)options->saves * sizeof *f->save);
    f->options.save = f->save;
    status = lay_out(f, domain, err);
  }
  if (status == SCT_OK) status = flow_bins_fill(f, err);
  if (status == SCT_OK) status = flow_measure(f, NULL, err);
  if (status == SCT_OK) status = flow_reserve_views(f, err);
  if (status != SCT_OK) sct_flow_free(&f);
  *out = f;
  return status;
}

void sct_flow_free(sct_flow **flow) {
  sct_flow *f = *flow;
  if (f == NULL) return;
  for (int64_t k = 0; f->snapshot != NULL && k < f->snapshots; k++) {
    sct_release(&f->snapshot[k].x);
    sct_release(&f->snapshot[k].u);
    sct_release(&f->snapshot[k].c);
  }
  flow_bins_clear(f);
  flow_mesh_clear(&f->mesh);
  sct_cholesky_free(&f->factor);
  for (int a = 0; a < 2; a++) {
    sct_release(&f->face[a]);
    sct_release(&f->change[a]);
    sct_release(&f->mean[a]);
  }
  void *const others[] = {f->save,   f->unknown, f->right,    f->phi,     f->wall,     f->inlet,
                          f->seed,   f->seeded,  f->mean_phi, f->history, f->snapshot, f->view_x,
                          f->view_u, f->view_c,  f->wall_x,   f->wall_u};
  for (size_t k = 0; k < sizeof others / sizeof others[0]; k++) free(others[k]);
  sct_release(flow);
}

/* ---- steps ---- */

static int64_t stops(const sct_flow *f) {
  const int64_t n = f->options.saves;
  return n > 0 && f->save[n - 1] == f->options.end ? n : n + 1;
}

bool sct_flow_is_done(const sct_flow *f) {
  return f->next_stop >= stops(f);
}

/* Courant rates: the largest |u| / min(delta, dx) over cells and walls. */
static double fastest(const sct_flow *f) {
  const flow_mesh *m = &f->mesh;
  double rate = 0;
  for (int64_t j = FLOW_PAD; j <= m->axis[1].n - FLOW_PAD; j++) {
    for (int64_t i = FLOW_PAD; i <= m->axis[0].n - FLOW_PAD; i++) {
      const double w[2] = {m->axis[0].width[i], m->axis[1].width[j]}, delta = sqrt(w[0] * w[1]);
      for (int a = 0; a < 2; a++) {
        const int64_t face = flow_face_below(m, a, i, j);
        if (m->kind[a][face] == FACE_NONE) continue;
        const double r = fabs(f->face[a][face]) / fmin(delta, w[a]);
        rate = r <= rate ? rate : r; /* a NaN stays */
      }
    }
  }
  for (int64_t k = 0; k < m->bounds; k++) {
    const flow_bound *b = &m->bound[k];
    const double w[2] = {m->axis[0].width[b->i], m->axis[1].width[b->j]}, delta = sqrt(w[0] * w[1]);
    if (b->kind == FACE_OUTFLOW) continue;
    for (int a = 0; a < 2; a++) rate = fmax(rate, fabs(b->velocity[a]) / fmin(delta, w[a]));
  }
  return rate;
}

/* Length of the next step: stable, and an even part of what is left to the next stop. */
static sct_status next_step(const sct_flow *f, double *dt, sct_error *err) {
  const double rate = fastest(f), nu = fmax(f->options.viscosity, f->options.diffusivity);
  const double stop = f->next_stop < f->options.saves ? f->save[f->next_stop] : f->options.end;
  const double left = stop - f->time, h = f->mesh.spacing;
  if (!isfinite(rate) || rate * h > RUNAWAY * f->speed) {
    return sct_fail(err, SCT_E_UNSTABLE, -1,
                    "velocities reached %g at t = %g, boundary and start have %g", rate * h,
                    f->time, f->speed);
  }
  double most = f->options.diffusion_number * f->stable * h * h / nu;
  if (rate > 0) most = fmin(most, f->options.courant / rate);
  const double steps = ceil(left / most * (1 - 1e-10));
  if (steps > 1e12) {
    return sct_fail(err, SCT_E_LIMIT, -1, "%g steps of %g are left to t = %g", steps, most, stop);
  }
  *dt = left / fmax(1, steps);
  return SCT_OK;
}

static sct_status one_step(sct_flow *f, double dt, const sct_work *work, sct_error *err) {
  sct_status status = flow_bins_fill(f, err);
  if (status == SCT_OK && f->controls && f->steps % CONTROL_EVERY == 0) {
    status = flow_control(f, work, err);
  }
  if (status != SCT_OK) return status;
  flow_walls_insulate(f);
  status = flow_rows_make(f, dt, work, err);
  if (status == SCT_OK) status = flow_transfer(f, work, err);
  if (status == SCT_OK) status = flow_project(f, err);
  if (status == SCT_OK) status = flow_move(f, dt, work, err);
  if (status == SCT_OK) status = flow_exchange(f, dt, err);
  if (status == SCT_OK) status = flow_reserve_views(f, err);
  f->step = dt;
  f->steps++;
  return status;
}

/* ---- what is kept of it ---- */

static sct_status take_snapshot(sct_flow *f, sct_error *err) {
  flow_snapshot *s = &f->snapshot[f->snapshots];
  const sct_flow_cloud now = sct_flow_particles(f);
  *s = (flow_snapshot){.time = f->time, .n = now.n};
  f->snapshots++;
  sct_status status = sct_alloc(&s->x, 2 * now.n, sizeof *s->x, err);
  if (status == SCT_OK) status = sct_alloc(&s->u, 2 * now.n, sizeof *s->u, err);
  if (status == SCT_OK && now.c != NULL) status = sct_alloc(&s->c, now.n, sizeof *s->c, err);
  if (status != SCT_OK) return status;
  memcpy(s->x, now.x, (size_t)(2 * now.n) * sizeof *s->x);
  memcpy(s->u, now.u, (size_t)(2 * now.n) * sizeof *s->u);
  if (now.c != NULL) memcpy(s->c, now.c, (size_t)now.n * sizeof *s->c);
  return SCT_OK;
}

/* Sample number k is due at k end / samples. */
static bool sample_is_due(const sct_flow *f) {
  const double next = f->options.end * (double)f->samples / (double)f->options.samples;
  return f->time >= next * (1 - 1e-12) && f->samples <= f->options.samples;
}

static sct_status keep(sct_flow *f, double dt, const sct_work *work, sct_error *err) {
  const bool stop =
      f->time == (f->next_stop < f->options.saves ? f->save[f->next_stop] : f->options.end);
  sct_status status = SCT_OK;
  /* a step that ends there is none of them, whatever rounding has made of its end */
  if (f->time > f->options.average_from * (1 + 1e-12)) flow_average(f, dt);
  if (sample_is_due(f)) {
    status = flow_bins_fill(f, err);
    if (status == SCT_OK) status = flow_measure(f, work, err);
  }
  if (status == SCT_OK && stop) {
    if (f->next_stop < f->options.saves) status = take_snapshot(f, err);
    f->next_stop++;
  }
  return status;
}

sct_status sct_flow_advance(sct_flow *f, int64_t steps, const sct_work *work, sct_error *err) {
  for (int64_t k = 0; k < steps && !sct_flow_is_done(f); k++) {
    double dt = 0;
    sct_status status = sct_work_report(work, "march", f->time / f->options.end, err);
    if (status == SCT_OK) status = next_step(f, &dt, err);
    if (status == SCT_OK) status = one_step(f, dt, work, err);
    if (status != SCT_OK) return status;
    const double stop = f->next_stop < f->options.saves ? f->save[f->next_stop] : f->options.end;
    f->time = stop - f->time <= dt * (1 + 1e-9) ? stop : f->time + dt;
    status = keep(f, dt, work, err);
    if (status != SCT_OK) return status;
  }
  return SCT_OK;
}

/* ---- views ---- */

sct_flow_cloud sct_flow_particles(const sct_flow *flow) {
  sct_flow *f = (sct_flow *)flow; /* the views are a cache */
  const flow_particles *p = &f->particles;
  for (int64_t k = 0; k < p->n; k++) {
    for (int a = 0; a < 2; a++) {
      f->view_x[2 * k + a] = p->x[a][k];
      f->view_u[2 * k + a] = p->field[a][k];
    }
    if (f->options.has_scalar) f->view_c[k] = p->field[FLOW_C][k];
  }
  return (sct_flow_cloud){f->time, p->n, f->view_x, f->view_u,
                          f->options.has_scalar ? f->view_c : NULL};
}

int64_t sct_flow_snapshots(const sct_flow *f) {
  return f->snapshots;
}

sct_flow_cloud sct_flow_snapshot(const sct_flow *f, int64_t k) {
  const flow_snapshot *s = &f->snapshot[k];
  return (sct_flow_cloud){s->time, s->n, s->x, s->u, s->c};
}

sct_flow_cloud sct_flow_wall_points(const sct_flow *flow) {
  return (sct_flow_cloud){flow->time, flow->walls, flow->wall_x, flow->wall_u, NULL};
}

int64_t sct_flow_history(const sct_flow *f, const sct_flow_sample **sample) {
  *sample = f->history;
  return f->samples;
}

sct_flow_report sct_flow_reports(const sct_flow *f) {
  const double mean = f->averaged > 0 ? f->mean_q / f->averaged : 0;
  const double mean2 = f->averaged > 0 ? f->mean_q2 / f->averaged : 0;
  return (sct_flow_report){.time = f->time,
                           .step = f->step,
                           .steps = f->steps,
                           .particles = f->particles.n,
                           .cells = f->mesh.fluids,
                           .inserted = f->inserted,
                           .removed = f->removed,
                           .circulation_deviation = sqrt(fmax(0, mean2 - mean * mean))};
}
