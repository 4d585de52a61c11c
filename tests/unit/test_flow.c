/* flow.h, piece by piece: rows against the general ones, fits, projection, exact states, state as
 * bytes, threads, bad input. What flows come to: verify_flow.c. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "../near.h"
#include "../seed.h"
#include "flow_inside.h"
#include "scatter/flow_case.h"

static void cavity(sct_scheme scheme, double jitter, uint64_t seed, sct_flow_case *c) {
  assert_int_equal(sct_flow_cavity(14, 100, 0, scheme, 1, c, NULL), SCT_OK);
  c->options.jitter = jitter;
  c->options.seed = seed;
}

static sct_flow *build(const sct_flow_case *c) {
  sct_flow *f = NULL;
  sct_error err = {0};
  char room[600];
  if (sct_flow_build(&c->domain, &c->options, &f, &err) != SCT_OK) {
    fail_msg("%s", sct_error_message(&err, room, sizeof room));
  }
  return f;
}

/* ---- rows ---- */

/* Particles, then wall points, as one cloud with a rough field. */
static void pose(sct_flow *f, double *x, double *u) {
  flow_particles *p = &f->particles;
  for (int64_t k = 0; k < p->n; k++) {
    x[2 * k] = p->x[0][k];
    x[2 * k + 1] = p->x[1][k];
    u[k] = p->field[FLOW_U][k] = sin(7 * x[2 * k]) + x[2 * k + 1] * x[2 * k + 1];
  }
  for (int64_t k = 0; k < f->walls; k++) {
    x[2 * (p->n + k)] = f->wall[k].x[0];
    x[2 * (p->n + k) + 1] = f->wall[k].x[1];
    u[p->n + k] = f->wall[k].velocity[0];
  }
}

/* Laplacian and gradient of the general stencil are those of the flow's sums. */
static void rows_equal(sct_scheme scheme, uint64_t seed) {
  sct_flow_case c;
  cavity(scheme, 0.2, seed, &c);
  const double dt = 1e-4;
  sct_flow *f = build(&c);
  const int64_t n = f->particles.n, all = n + f->walls;
  double *x = calloc((size_t)(2 * all), sizeof *x), *u = calloc((size_t)all, sizeof *u);
  double *gradient = calloc((size_t)(2 * all), sizeof *gradient);
  double *laplacian = calloc((size_t)all, sizeof *laplacian);
  assert_non_null(x && u && gradient && laplacian ? x : NULL);
  assert_int_equal(flow_bins_fill(f, NULL), SCT_OK);
  pose(f, x, u);
  assert_int_equal(flow_bins_fill(f, NULL), SCT_OK);
  assert_int_equal(flow_rows_make(f, dt, NULL, NULL), SCT_OK);
  const sct_cloud cloud = {2, all, x};
  sct_search *search = NULL;
  sct_stencil *stencil = NULL;
  sct_operator linear = sct_operator_default(SCT_IPS, 2);
  linear.radius = c.options.op.radius;
  assert_int_equal(sct_search_build(&cloud, 0, SCT_SEARCH_AUTO, NULL, &search, NULL), SCT_OK);
  const sct_operator *const ops[] = {&c.options.op, &linear};
  for (int k = 0; k < 2; k++) { /* the flow's gradient is that of ips in every scheme */
    assert_int_equal(sct_stencil_build(&cloud, search, 1.0 / 14, ops[k], 100, NULL, &stencil, NULL),
                     SCT_OK);
    assert_int_equal(sct_stencil_apply(stencil, u, NULL, NULL, k == 1 ? gradient : NULL,
                                       k == 0 ? laplacian : NULL, NULL),
                     SCT_OK);
    sct_stencil_free(&stencil);
  }
  for (int64_t p = 0; p < n; p++) {
    const double lap = (f->rows.diffused[FLOW_U][p] - u[p]) / (dt * c.options.viscosity);
    assert_int_equal(f->rows.limited[p], 0);
    if (scheme == SCT_LSMPS) { /* wall neighbourhoods may be widened, by other steps */
      const double to_wall =
          fmin(fmin(x[2 * p], 1 - x[2 * p]), fmin(x[2 * p + 1], 1 - x[2 * p + 1]));
      if (to_wall < 2.0 / 14) continue;
    }
    assert_near(lap, laplacian[p], 1e-6 * (1 + fabs(laplacian[p])));
    for (int a = 0; a < 2; a++) {
      assert_near(f->rows.gradient[FLOW_U][a][p], gradient[2 * p + a], 1e-9);
    }
  }
  sct_search_free(&search);
  free(x);
  free(u);
  free(gradient);
  free(laplacian);
  sct_flow_free(&f);
  sct_flow_case_clear(&c);
}

static void rows_are_those_of_stencils(void **state) {
  uint64_t seed = seed_new("unit.flow");
  (void)state;
  rows_equal(SCT_PS, seed);
  rows_equal(SCT_IPS, seed);
  rows_equal(SCT_IPSN, seed);
  rows_equal(SCT_LSMPS, seed);
}

/* ---- transfer ---- */

static void fits_are_exact_for_linear_fields(void **state) {
  sct_flow_case c;
  cavity(SCT_IPS, 0.5, seed_new("unit.flow"), &c);
  sct_flow *f = build(&c);
  flow_particles *p = &f->particles;
  (void)state;
  for (int64_t k = 0; k < p->n; k++) {
    p->field[FLOW_U][k] = 3 - 2 * p->x[0][k] + 5 * p->x[1][k];
    p->field[FLOW_V][k] = 1 + 4 * p->x[0][k] - p->x[1][k];
  }
  assert_int_equal(flow_bins_fill(f, NULL), SCT_OK);
  for (int k = 0; k < 50; k++) {
    const double x[2] = {0.2 + 0.6 * flow_random(f, 1, (uint64_t)(2 * k)),
                         0.2 + 0.6 * flow_random(f, 1, (uint64_t)(2 * k + 1))};
    const double reach[2] = {1.7 / 14, 1.7 / 14};
    double value[FLOW_FIELDS];
    flow_fit_at(f, x, reach, value);
    assert_near(value[FLOW_U], 3 - 2 * x[0] + 5 * x[1], 1e-11);
    assert_near(value[FLOW_V], 1 + 4 * x[0] - x[1], 1e-11);
  }
  sct_flow_free(&f);
  sct_flow_case_clear(&c);
}

/* ---- projection ---- */

static void projection_leaves_no_divergence(void **state) {
  uint64_t seed = seed_new("unit.flow");
  sct_flow_case c;
  sct_flow *f;
  (void)state;
  assert_int_equal(sct_flow_step(6, 100, 0.3, 4, SCT_IPS, 1, &c, NULL), SCT_OK);
  f = build(&c);
  for (int a = 0; a < 2; a++) {
    for (int64_t k = 0; k < f->mesh.faces[a]; k++) {
      const bool free_face = f->mesh.kind[a][k] == FACE_INNER || f->mesh.kind[a][k] == FACE_OUTFLOW;
      if (free_face) f->face[a][k] = seed_uniform(&seed, -1, 1);
    }
  }
  assert_int_equal(flow_project(f, NULL), SCT_OK);
  assert_true(f->divergence_before > 1);
  assert_true(f->divergence < 1e-11);
  for (int64_t k = 0; k < f->mesh.bounds; k++) { /* what is prescribed stays */
    const flow_bound *b = &f->mesh.bound[k];
    if (b->kind != FACE_OUTFLOW) assert_near(f->face[b->axis][b->face], b->mean, 0);
  }
  sct_flow_free(&f);
  sct_flow_case_clear(&c);
}

/* ---- exact states ---- */

/* u = y, v = 0 between a wall at rest and one that moves, in through the left, out at the right. */
static sct_status shear(void *context, int64_t n, const double *x, double *u, sct_error *err) {
  (void)context;
  (void)err;
  for (int64_t k = 0; k < n; k++) {
    u[2 * k] = x[2 * k + 1];
    u[2 * k + 1] = 0;
  }
  return SCT_OK;
}

static sct_status height(void *context, int64_t n, const double *x, double *c, sct_error *err) {
  (void)context;
  (void)err;
  for (int64_t k = 0; k < n; k++) c[k] = x[2 * k + 1];
  return SCT_OK;
}

/* ips is exact for linear fields, and so is everything else in a step: Couette flow stays, to
 * rounding, while particles enter and leave; a passive scalar that is linear too. */
static void couette_stays(sct_scheme scheme, double clustering, sct_flow_walls walls) {
  enum { NX = 20, NY = 10 };
  double ex[NX + 1], ey[NY + 1];
  sct_flow_lines(0, 2, NX, 0, ex);
  sct_flow_lines(0, 1, NY, clustering, ey);
  const sct_flow_side sides[] = {
      {.kind = SCT_FLOW_WALL, .from = {0, 0}, .to = {2, 0}, .has_scalar = true},
      {.kind = SCT_FLOW_WALL,
       .from = {0, 1},
       .to = {2, 1},
       .velocity = {1, 0},
       .has_scalar = true,
       .scalar = 1},
      {.kind = SCT_FLOW_INFLOW, .from = {0, 0}, .to = {0, 1}, .profile = shear},
      {.kind = SCT_FLOW_OUTFLOW, .from = {2, 1}, .to = {2, 0}}};
  const sct_flow_domain domain = {.cells = {NX, NY}, .edge = {ex, ey}, .side = sides, .sides = 4};
  sct_flow_options options = sct_flow_default(scheme, 0.01, 1);
  sct_flow *f = NULL;
  options.walls = walls;
  options.jitter = 0.3;
  options.has_scalar = true;
  options.diffusivity = 0.005;
  options.initial = height;
  assert_int_equal(sct_flow_build(&domain, &options, &f, NULL), SCT_OK);
  flow_particles *p = &f->particles;
  for (int64_t k = 0; k < p->n; k++) {
    p->field[FLOW_U][k] = p->x[1][k];
    p->field[FLOW_V][k] = 0;
  }
  for (int64_t k = 0; k < f->mesh.bounds; k++) { /* the inflow's scalar is one number per side */
    flow_bound *b = &f->mesh.bound[k];
    if (b->kind == FACE_INFLOW) b->scalar = f->mesh.axis[1].centre[b->j];
  }
  assert_int_equal(sct_flow_advance(f, 60, NULL, NULL), SCT_OK);
  assert_true(f->time > 0.5 && f->inserted > 20 && f->removed > 20);
  for (int64_t k = 0; k < p->n; k++) {
    assert_near(p->field[FLOW_U][k], p->x[1][k], 1e-9);
    assert_near(p->field[FLOW_V][k], 0, 1e-9);
    assert_near(p->field[FLOW_C][k], p->x[1][k], 1e-9);
  }
  sct_flow_free(&f);
}

static void couette_flow_stays(void **state) {
  (void)state;
  couette_stays(SCT_IPS, 0, SCT_FLOW_WALL_POINTS);
  couette_stays(SCT_IPS, 0.3, SCT_FLOW_WALL_POINTS);
  couette_stays(SCT_IPSN, 0, SCT_FLOW_WALL_POINTS);
  couette_stays(SCT_LSMPS, 0, SCT_FLOW_WALL_POINTS);
  couette_stays(SCT_IPS, 0, SCT_FLOW_WALL_MIRROR);
}

/* ---- state ---- */

static void scalar_case(sct_flow_case *c, double *save) {
  assert_int_equal(sct_flow_step(5, 100, 0.3, 3, SCT_IPS, 2, c, NULL), SCT_OK);
  c->options.has_scalar = true;
  c->options.diffusivity = 0.02;
  c->side[0].has_scalar = true;
  c->side[0].scalar = 1;
  c->options.save = save;
  c->options.saves = 2;
}

/* Saved in the middle and loaded into another flow, it ends as if nothing had been. */
static void state_goes_on_bit_for_bit(void **state) {
  double save[] = {0.3, 1.1};
  void *bytes = NULL, *end = NULL, *other_end = NULL;
  size_t size, end_size, other_size;
  sct_flow_case c;
  (void)state;
  scalar_case(&c, save);
  sct_flow *f = build(&c), *g = build(&c);
  assert_int_equal(sct_flow_advance(f, 20, NULL, NULL), SCT_OK);
  assert_int_equal(sct_flow_snapshots(f), 1);
  assert_int_equal(sct_flow_save(f, &bytes, &size, NULL), SCT_OK);
  assert_int_equal(sct_flow_advance(g, 7, NULL, NULL), SCT_OK);
  assert_int_equal(sct_flow_load(g, bytes, size, NULL), SCT_OK);
  assert_int_equal(sct_flow_advance(f, INT64_MAX, NULL, NULL), SCT_OK);
  assert_int_equal(sct_flow_advance(g, INT64_MAX, NULL, NULL), SCT_OK);
  assert_true(sct_flow_is_done(f) && sct_flow_is_done(g));
  assert_int_equal(sct_flow_save(f, &end, &end_size, NULL), SCT_OK);
  assert_int_equal(sct_flow_save(g, &other_end, &other_size, NULL), SCT_OK);
  assert_int_equal(end_size, other_size);
  assert_memory_equal(end, other_end, end_size);
  free(bytes);
  free(end);
  free(other_end);
  sct_flow_free(&f);
  sct_flow_free(&g);
  sct_flow_case_clear(&c);
}

static void foreign_and_damaged_states_are_refused(void **state) {
  double save[] = {0.3, 1.1};
  void *bytes = NULL;
  size_t size;
  sct_flow_case c, other;
  uint64_t seed = seed_new("unit.flow");
  (void)state;
  scalar_case(&c, save);
  scalar_case(&other, save);
  other.options.viscosity *= 2;
  sct_flow *f = build(&c), *g = build(&other);
  assert_int_equal(sct_flow_advance(f, 20, NULL, NULL), SCT_OK);
  assert_int_equal(sct_flow_save(f, &bytes, &size, NULL), SCT_OK);
  assert_int_equal(sct_flow_load(g, bytes, size, NULL), SCT_E_ARGUMENT);
  assert_int_equal(sct_flow_load(f, bytes, size - 1, NULL), SCT_E_ARGUMENT);
  assert_int_equal(sct_flow_load(f, bytes, 7, NULL), SCT_E_ARGUMENT);
  for (int k = 0; k < 300; k++) { /* all of the head, and anywhere */
    unsigned char *at = (unsigned char *)bytes + (k < 64 ? k : seed_below(&seed, (int)size));
    *at ^= 1;
    assert_int_equal(sct_flow_load(f, bytes, size, NULL), SCT_E_ARGUMENT);
    *at ^= 1;
  }
  assert_int_equal(sct_flow_load(f, bytes, size, NULL), SCT_OK);
  free(bytes);
  sct_flow_free(&f);
  sct_flow_free(&g);
  sct_flow_case_clear(&c);
  sct_flow_case_clear(&other);
}

static void threads_change_nothing(void **state) {
  void *bytes[2] = {NULL, NULL};
  size_t size[2];
  (void)state;
  for (int t = 0; t < 2; t++) {
    sct_flow_case c;
    const sct_work work = {.threads = 1 + 2 * t};
    assert_int_equal(sct_flow_step(9, 100, 0.3, 4, SCT_IPS, 0.3, &c, NULL), SCT_OK);
    sct_flow *f = build(&c);
    assert_int_equal(sct_flow_advance(f, INT64_MAX, &work, NULL), SCT_OK);
    assert_int_equal(sct_flow_save(f, &bytes[t], &size[t], NULL), SCT_OK);
    sct_flow_free(&f);
    sct_flow_case_clear(&c);
  }
  assert_int_equal(size[0], size[1]);
  assert_memory_equal(bytes[0], bytes[1], size[0]);
  free(bytes[0]);
  free(bytes[1]);
}

/* ---- cancelling ---- */

static bool stop_at_ten(void *context, const char *phase, double fraction) {
  int *calls = context;
  assert_string_equal(phase, "march");
  assert_true(fraction >= 0 && fraction < 1);
  return ++*calls <= 10;
}

static void a_run_is_cancelled_between_steps(void **state) {
  int calls = 0;
  const sct_work work = {.report = stop_at_ten, .context = &calls};
  sct_flow_case c;
  cavity(SCT_IPS, 0, 0, &c);
  sct_flow *f = build(&c);
  (void)state;
  assert_int_equal(sct_flow_advance(f, INT64_MAX, &work, NULL), SCT_E_CANCELLED);
  assert_int_equal(sct_flow_reports(f).steps, 10);
  assert_int_equal(sct_flow_advance(f, INT64_MAX, NULL, NULL), SCT_OK);
  assert_true(sct_flow_is_done(f));
  assert_near(sct_flow_reports(f).time, 1, 0);
  sct_flow_free(&f);
  sct_flow_case_clear(&c);
}

/* ---- bad input ---- */

static sct_status through(void *context, int64_t n, const double *x, double *u, sct_error *err) {
  (void)x;
  (void)err;
  for (int64_t k = 0; k < 2 * n; k++) u[k] = *(const double *)context;
  return SCT_OK;
}

typedef struct {
  const char *what;
  sct_status status;
  void (*spoil)(sct_flow_case *c);
} spoiled;

static double not_a_number = NAN;
static void spoil_lines(sct_flow_case *c) {
  c->edge[0][3] = c->edge[0][2];
}
static void spoil_line(sct_flow_case *c) {
  c->edge[1][3] = NAN;
}
static void spoil_cells(sct_flow_case *c) {
  c->domain.cells[0] = 1;
}
static void spoil_viscosity(sct_flow_case *c) {
  c->options.viscosity = 0;
}
static void spoil_scheme(sct_flow_case *c) {
  c->options.op = sct_operator_default(SCT_MPS, 2);
}
static void spoil_radius(sct_flow_case *c) {
  c->options.op.radius = 3.5;
}
static void spoil_shift(sct_flow_case *c) {
  c->options.shift = NAN;
}
static void spoil_walls(sct_flow_case *c) {
  c->options.walls = SCT_FLOW_WALLS_COUNT;
}
static void spoil_side(sct_flow_case *c) {
  c->side[0].from[0] = 0.123;
}
static void spoil_inside(sct_flow_case *c) {
  c->side[0].from[1] = c->side[0].to[1] = 0.5;
}
static void spoil_through(sct_flow_case *c) {
  c->side[0].velocity[1] = 1;
}
static void spoil_inflow(sct_flow_case *c) {
  c->side[0].kind = SCT_FLOW_INFLOW;
  c->side[0].velocity[1] = -1;
}
static void spoil_profile(sct_flow_case *c) {
  c->side[0].profile = through;
  c->side[0].context = &not_a_number;
}
static void spoil_all(sct_flow_case *c) {
  c->solid = (sct_flow_box){{0, 0}, {1, 1}};
  c->domain.solid = &c->solid;
  c->domain.solids = 1;
}
static void spoil_thin(sct_flow_case *c) {
  c->solid = (sct_flow_box){{0.5, 0}, {0.5 + 1.0 / 14, 0.5}};
  c->domain.solid = &c->solid;
  c->domain.solids = 1;
}
static void spoil_block(sct_flow_case *c) {
  c->solid = (sct_flow_box){{0.51, 0}, {0.8, 0.5}};
  c->domain.solid = &c->solid;
  c->domain.solids = 1;
}
static void spoil_limit(sct_flow_case *c) {
  c->options.max_particles = 100;
}
static void spoil_save(sct_flow_case *c) {
  static const double save[] = {0.5, 0.5};
  c->options.save = save;
  c->options.saves = 2;
}

static void bad_input_is_refused(void **state) {
  static const spoiled all[] = {
      {"lines", SCT_E_ARGUMENT, spoil_lines},       {"line", SCT_E_ARGUMENT, spoil_line},
      {"cells", SCT_E_ARGUMENT, spoil_cells},       {"viscosity", SCT_E_ARGUMENT, spoil_viscosity},
      {"scheme", SCT_E_ARGUMENT, spoil_scheme},     {"radius", SCT_E_ARGUMENT, spoil_radius},
      {"shift", SCT_E_ARGUMENT, spoil_shift},       {"walls", SCT_E_ARGUMENT, spoil_walls},
      {"side", SCT_E_ARGUMENT, spoil_side},         {"inside", SCT_E_ARGUMENT, spoil_inside},
      {"through", SCT_E_ARGUMENT, spoil_through},   {"inflow", SCT_E_ARGUMENT, spoil_inflow},
      {"profile", SCT_E_NOT_FINITE, spoil_profile}, {"all", SCT_E_ARGUMENT, spoil_all},
      {"thin", SCT_E_ARGUMENT, spoil_thin},         {"block", SCT_E_ARGUMENT, spoil_block},
      {"limit", SCT_E_LIMIT, spoil_limit},          {"save", SCT_E_ARGUMENT, spoil_save}};
  (void)state;
  for (size_t k = 0; k < sizeof all / sizeof all[0]; k++) {
    sct_flow_case c;
    cavity(SCT_IPS, 0, 0, &c);
    sct_flow *f = (sct_flow *)&c;
    sct_error err = {0};
    all[k].spoil(&c);
    const sct_status status = sct_flow_build(&c.domain, &c.options, &f, &err);
    if (status != all[k].status) fail_msg("%s: status %d, %s", all[k].what, status, err.text);
    assert_null(f);
    assert_true(strlen(err.text) > 10);
    sct_flow_case_clear(&c);
  }
}

/* A block in a channel: fluid goes round it, nothing gets in. */
static void a_block_is_flown_round(void **state) {
  enum { NX = 40, NY = 20 };
  double ex[NX + 1], ey[NY + 1], one[2] = {1, 0};
  sct_flow_lines(0, 2, NX, 0, ex);
  sct_flow_lines(0, 1, NY, 0, ey);
  const sct_flow_box block = {{0.5, 0.4}, {0.7, 0.6}};
  const sct_flow_side sides[] = {
      {.kind = SCT_FLOW_INFLOW, .from = {0, 0}, .to = {0, 1}, .velocity = {one[0], one[1]}},
      {.kind = SCT_FLOW_OUTFLOW, .from = {2, 1}, .to = {2, 0}}};
  const sct_flow_domain domain = {
      .cells = {NX, NY}, .edge = {ex, ey}, .solid = &block, .solids = 1, .side = sides, .sides = 2};
  sct_flow_options options = sct_flow_default(SCT_IPS, 0.02, 1.5);
  sct_flow *f = NULL;
  (void)state;
  for (int walls = 0; walls < 2; walls++) {
    options.walls = (sct_flow_walls)walls;
    assert_int_equal(sct_flow_build(&domain, &options, &f, NULL), SCT_OK);
    assert_int_equal(sct_flow_advance(f, INT64_MAX, NULL, NULL), SCT_OK);
    const sct_flow_cloud p = sct_flow_particles(f);
    for (int64_t k = 0; k < p.n; k++) {
      const double x = p.x[2 * k], y = p.x[2 * k + 1];
      assert_true(x >= 0 && x <= 2 && y >= 0 && y <= 1);
      assert_false(x > 0.5 && x < 0.7 && y > 0.4 && y < 0.6);
    }
    assert_true(fabs((double)p.n / (double)sct_flow_reports(f).cells - 1) < 0.1);
    double s[NY + 2], u[NY + 2], flux = 0;
    const int64_t n = sct_flow_section(f, true, 0, 1.5, s, u);
    assert_int_equal(n, NY + 2);
    for (int64_t k = 1; k <= NY; k++) flux += u[k] / NY;
    assert_near(flux, 1, 1e-10);
    sct_flow_free(&f);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(rows_are_those_of_stencils),
                                     cmocka_unit_test(fits_are_exact_for_linear_fields),
                                     cmocka_unit_test(projection_leaves_no_divergence),
                                     cmocka_unit_test(couette_flow_stays),
                                     cmocka_unit_test(state_goes_on_bit_for_bit),
                                     cmocka_unit_test(foreign_and_damaged_states_are_refused),
                                     cmocka_unit_test(threads_change_nothing),
                                     cmocka_unit_test(a_run_is_cancelled_between_steps),
                                     cmocka_unit_test(bad_input_is_refused),
                                     cmocka_unit_test(a_block_is_flown_round)};
  return cmocka_run_group_tests_name("unit.flow", tests, NULL, NULL);
}
