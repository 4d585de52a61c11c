/* Flows against finite-volume solutions (tests/reference/flow.json), against themselves where they
 * are known, and the cloud while it moves. The runs that are too long for here: bench/flow.py. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "../near.h"
#include "scatter/flow_case.h"

/* Sanitizers make it some twenty times slower. */
#if defined(__SANITIZE_ADDRESS__)
enum { IS_SLOW = 1 };
#else
enum { IS_SLOW = 0 };
#endif

static cJSON *reference;

static int read_reference(void **state) {
  static char text[1 << 16];
  FILE *in = fopen(FLOW_REFERENCE, "r");
  (void)state;
  if (in == NULL) return 1;
  text[fread(text, 1, sizeof text - 1, in)] = '\0';
  fclose(in);
  reference = cJSON_Parse(text);
  return reference == NULL;
}

static int forget_reference(void **state) {
  (void)state;
  cJSON_Delete(reference);
  return 0;
}

/* Numbers of an array: returns how many. */
static int numbers(const cJSON *array, double *out, int most) {
  const cJSON *one;
  int n = 0;
  cJSON_ArrayForEach(one, array) {
    assert_true(n < most);
    out[n++] = one->valuedouble;
  }
  assert_true(n > 0);
  return n;
}

/* Value at x of the cubic through the four known places around. */
static double between(int n, const double *s, const double *v, double x) {
  int k = 1;
  double sum = 0;
  while (k < n - 3 && x > s[k + 1]) k++;
  for (int a = k - 1; a < k + 3; a++) {
    double l = v[a];
    for (int b = k - 1; b < k + 3; b++) {
      if (b != a) l *= (x - s[b]) / (s[a] - s[b]);
    }
    sum += l;
  }
  return sum;
}

enum { MOST = 200 };

/* Root mean square of a section less a reference profile. */
static double section_error(const sct_flow *f, int along, double at, const cJSON *places,
                            const cJSON *values) {
  double s[MOST], v[MOST], known_s[MOST], known_v[MOST], sum = 0;
  const int known = numbers(places, known_s, MOST);
  int64_t count = 0;
  assert_int_equal(numbers(values, known_v, MOST), known);
  assert_true(sct_flow_section_most(f, along) <= MOST);
  const int64_t n = sct_flow_section(f, false, along, at, s, v);
  for (int64_t k = 1; k < n - 1; k++) {
    if (s[k] > known_s[known - 1]) continue;
    const double e = v[k] - between(known, known_s, known_v, s[k]);
    sum += e * e;
    count++;
  }
  assert_true(count > 10);
  return sqrt(sum / (double)count);
}

static sct_flow *run(sct_flow_case *c, int threads) {
  const sct_work work = {.threads = threads};
  sct_flow *f = NULL;
  sct_error err = {0};
  char room[600];
  if (sct_flow_build(&c->domain, &c->options, &f, &err) != SCT_OK ||
      sct_flow_advance(f, INT64_MAX, &work, &err) != SCT_OK) {
    fail_msg("%s", sct_error_message(&err, room, sizeof room));
  }
  return f;
}

/* The cloud stays good and the divergence is rounding, in all of the history. */
static void expect_good_cloud(const sct_flow *f, double most_empty) {
  const sct_flow_sample *h;
  const int64_t n = sct_flow_history(f, &h);
  const double cells = (double)sct_flow_reports(f).cells;
  assert_true(n == 201 && h[n - 1].t == sct_flow_reports(f).time);
  for (int64_t k = 0; k < n; k++) {
    assert_true(h[k].divergence < 1e-9);
    assert_true(fabs(h[k].particles / cells - 1) <= 0.1);
    assert_true(h[k].speed < 2);
    if (k < n / 10) continue;
    assert_true(h[k].empty <= most_empty + 0.04); /* on average over time: below */
    assert_true(h[k].nearest_1 >= 0.55);
    assert_true(h[k].limited < 1e-3);
  }
  double empty = 0, nearest = 0;
  for (int64_t k = n / 2; k < n; k++) {
    empty += h[k].empty / (double)(n - n / 2);
    nearest += h[k].nearest_1 / (double)(n - n / 2);
  }
  printf("  empty cells %.3f, nearest neighbour (1 %%) %.3f spacings\n", empty, nearest);
  assert_true(empty <= most_empty);
  assert_true(nearest >= 0.6);
}

/* ---- cavity ---- */

typedef struct {
  double circulation, u, v, in_time; /* relative, and root mean squares */
} cavity_errors;

static cavity_errors cavity(int64_t cells, sct_scheme scheme, sct_flow_walls walls) {
  const cJSON *known = cJSON_GetObjectItem(reference, "cavity");
  const double q = cJSON_GetObjectItem(known, "circulation")->valuedouble;
  sct_flow_case c;
  assert_int_equal(sct_flow_cavity(cells, 100, 0, scheme, 20, &c, NULL), SCT_OK);
  c.options.walls = walls;
  sct_flow *f = run(&c, 1);
  const cJSON *s = cJSON_GetObjectItem(known, "s"), *h = cJSON_GetObjectItem(known, "history");
  const sct_flow_vortex vortex = sct_flow_find_vortex(f, false);
  cavity_errors e = {.circulation = vortex.circulation / q - 1,
                     .u = section_error(f, 0, 0.5, s, cJSON_GetObjectItem(known, "u")),
                     .v = section_error(f, 1, 0.5, s, cJSON_GetObjectItem(known, "v"))};
  double t[MOST], circulation[MOST], sum = 0;
  const int times = numbers(cJSON_GetObjectItem(h, "t"), t, MOST);
  numbers(cJSON_GetObjectItem(h, "circulation"), circulation, MOST);
  const sct_flow_sample *sample;
  sct_flow_history(f, &sample);
  for (int k = 0; k < times; k++) { /* 200 samples of t = 20 */
    const sct_flow_sample *at = &sample[(int)lround(10 * t[k])];
    assert_near(at->t, t[k], 0.02);
    sum += (at->circulation - circulation[k]) * (at->circulation - circulation[k]) / times;
  }
  e.in_time = sqrt(sum);
  printf(
      "cavity %d %s %s: circulation %+.2f %%, rms u %.4f v %.4f, in time %.5f, vortex %.4f %.4f\n",
      (int)cells, sct_scheme_name(scheme), sct_flow_walls_name(walls), 100 * e.circulation, e.u,
      e.v, e.in_time, vortex.x, vortex.y);
  if (scheme == SCT_IPS) {
    expect_good_cloud(f, 0.16);
    assert_near(vortex.x, 0.6155, 0.02);
    assert_near(vortex.y, 0.7373, 0.02);
  }
  sct_flow_free(&f);
  sct_flow_case_clear(&c);
  return e;
}

static void cavity_of_20_cells(void **state) {
  (void)state;
  for (int walls = 0; walls < SCT_FLOW_WALLS_COUNT; walls++) {
    const cavity_errors e = cavity(20, SCT_IPS, (sct_flow_walls)walls);
    assert_true(fabs(e.circulation) < 0.025);
    assert_true(e.u < 5e-3 && e.v < 5e-3);
  }
  /* reported, not required: whatever comes out, it is a flow */
  const cavity_errors ps = cavity(20, SCT_PS, SCT_FLOW_WALL_POINTS);
  assert_true(fabs(ps.circulation) < 0.2);
}

static void cavity_of_40_cells(void **state) {
  (void)state;
  if (IS_SLOW) skip();
  const cavity_errors e = cavity(40, SCT_IPS, SCT_FLOW_WALL_POINTS);
  assert_true(fabs(e.circulation) < 0.01);
  assert_true(e.u < 3e-3 && e.v < 3e-3);
  assert_true(e.in_time < 1e-3);
}

/* ---- step ---- */

/* A coarse and short step: the bands of the method are for 17 cells and more (bench/flow.py). */
static void step(double clustering, double low, double high, double most) {
  const cJSON *known = cJSON_GetObjectItem(reference, "step");
  const cJSON *profiles = cJSON_GetObjectItem(known, "u"), *y = cJSON_GetObjectItem(known, "y");
  const double at[] = {0.5, 1, 2, 3, 4};
  double sum = 0;
  sct_flow_case c;
  assert_int_equal(sct_flow_step(10, 100, clustering, 7, SCT_IPS, 32, &c, NULL), SCT_OK);
  sct_flow *f = run(&c, 1);
  for (int k = 0; k < 5; k++) {
    const double e = section_error(f, 0, at[k] * c.step_height, y, cJSON_GetArrayItem(profiles, k));
    sum += e * e / 5;
  }
  const double length = sct_flow_reattachment(f, false, 0, 0) / c.step_height;
  printf("step 10, clustering %g: reattachment %.3f, rms %.4f\n", clustering, length, sqrt(sum));
  assert_true(length > low && length < high);
  assert_true(sqrt(sum) < most);
  expect_good_cloud(f, clustering > 0 ? 0.2 : 0.16); /* cells at walls flatter than the spacing */
  sct_flow_free(&f);
  sct_flow_case_clear(&c);
}

static void step_on_a_uniform_mesh(void **state) {
  (void)state;
  if (IS_SLOW) skip();
  step(0, 2.7, 3.0, 0.02);
}

static void step_on_a_graded_mesh(void **state) {
  (void)state;
  if (IS_SLOW) skip();
  step(0.3, 2.65, 3.0, 0.02);
}

/* ---- Poiseuille ---- */

static sct_status parabola(void *context, int64_t n, const double *x, double *u, sct_error *err) {
  (void)context;
  (void)err;
  for (int64_t k = 0; k < n; k++) {
    u[2 * k] = 6 * x[2 * k + 1] * (1 - x[2 * k + 1]);
    u[2 * k + 1] = 0;
  }
  return SCT_OK;
}

/* From potential flow to the parabola of the inlet and its pressure gradient, -12 nu. */
static void poiseuille_flow_comes_up(void **state) {
  enum { NX = 40, NY = 16 };
  double ex[NX + 1], ey[NY + 1], s[NY + 2], u[NY + 2], p[NX * NY];
  const double nu = 0.05;
  sct_flow_lines(0, 2.5, NX, 0, ex);
  sct_flow_lines(0, 1, NY, 0, ey);
  const sct_flow_side sides[] = {
      {.kind = SCT_FLOW_INFLOW, .from = {0, 0}, .to = {0, 1}, .profile = parabola},
      {.kind = SCT_FLOW_OUTFLOW, .from = {2.5, 1}, .to = {2.5, 0}}};
  const sct_flow_domain domain = {.cells = {NX, NY}, .edge = {ex, ey}, .side = sides, .sides = 2};
  sct_flow_options options = sct_flow_default(SCT_IPS, nu, 8);
  sct_flow *f = NULL;
  (void)state;
  options.shift = 0.5;
  assert_int_equal(sct_flow_build(&domain, &options, &f, NULL), SCT_OK);
  assert_int_equal(sct_flow_advance(f, INT64_MAX, NULL, NULL), SCT_OK);
  assert_int_equal(sct_flow_section(f, false, 0, 1.6, s, u), NY + 2);
  for (int k = 0; k < NY + 2; k++) assert_near(u[k], 6 * s[k] * (1 - s[k]), 0.02);
  sct_flow_mesh(f, false, p, NULL, NULL, NULL);
  const double slope = (p[8 * NX + 30] - p[8 * NX + 10]) / (20 * 2.5 / NX);
  assert_near(slope / (-12 * nu), 1, 0.04);
  sct_flow_free(&f);
}

/* ---- a scalar on the flow ---- */

static sct_status wave(void *context, int64_t n, const double *x, double *c, sct_error *err) {
  (void)context;
  (void)err;
  for (int64_t k = 0; k < n; k++) c[k] = cos(3.14159265358979323846 * x[2 * k]);
  return SCT_OK;
}

/* Fluid at rest in a closed box without flux: cos(pi x) decays by e^(-kappa pi^2 t), its mean
 * stays. In the moving fluid of the cavity the values stay between those at the start. */
static void a_scalar_diffuses(void **state) {
  const double kappa = 0.02, end = 2, pi = 3.14159265358979323846;
  (void)state;
  for (int moving = 0; moving < 2; moving++) {
    sct_flow_case c;
    assert_int_equal(sct_flow_cavity(20, 100, 0, SCT_IPS, end, &c, NULL), SCT_OK);
    c.side[0].velocity[0] = moving;
    c.options.has_scalar = true;
    c.options.diffusivity = kappa;
    c.options.initial = wave;
    sct_flow *f = run(&c, 2);
    const sct_flow_cloud p = sct_flow_particles(f);
    double mean = 0, worst = 0, most = 0;
    for (int64_t k = 0; k < p.n; k++) {
      const double exact = exp(-kappa * pi * pi * end) * cos(pi * p.x[2 * k]);
      mean += p.c[k] / (double)p.n;
      worst = fmax(worst, fabs(p.c[k] - exact));
      most = fmax(most, fabs(p.c[k]));
    }
    printf("scalar, lid %d: mean %.2e, worst %.4f, most %.3f\n", moving, mean, worst, most);
    assert_near(mean, 0, moving ? 0.03 : 1e-3);
    assert_true(most < 1);
    if (!moving) assert_true(worst < 0.025);
    sct_flow_free(&f);
    sct_flow_case_clear(&c);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(cavity_of_20_cells),       cmocka_unit_test(cavity_of_40_cells),
      cmocka_unit_test(step_on_a_uniform_mesh),   cmocka_unit_test(step_on_a_graded_mesh),
      cmocka_unit_test(poiseuille_flow_comes_up), cmocka_unit_test(a_scalar_diffuses)};
  return cmocka_run_group_tests_name("verify.flow", tests, read_reference, forget_reference);
}
