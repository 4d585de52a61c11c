/* verify.order: observed order of every scheme on jittered clouds (alpha = 0.3), means over clouds:
 * gradient and Laplacian inside, where neighbourhoods are one-sided and at the rim of a void,
 * steady and transient manufactured problems, also with gaps in the cloud and around a hole. Prints
 * the table of lib/README.md. Besides what has to converge, it is tested what must not: that ps
 * gets worse and ips stalls is as much a statement of the documentation as that lsmps converges. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "manufactured.h"
#include "seed.h"

enum { MESHES = 3 };
static const double ALPHA = 0.3;
static const int64_t MESH[][MESHES] = {{0}, {20, 40, 80}, {12, 24, 48}, {8, 11, 14}};
static const int CLOUDS[] = {0, 8, 4, 2};

/* --- clouds -------------------------------------------------------------------------------- */

static const double MIDDLE[] = {0.47, 0.45, 0.49}, HOLE = 0.23;

static double distance(int dim, const double *x, const double *from) {
  double r2 = 0;
  for (int a = 0; a < dim; a++) r2 += (x[a] - from[a]) * (x[a] - from[a]);
  return sqrt(r2);
}

/* Removes the points within a ball from x [n][dim] and inside [n]. Returns how many are left. */
static int64_t bore(int dim, int64_t n, const double *from, double radius, double *x,
                    uint8_t *inside) {
  int64_t kept = 0;
  for (int64_t i = 0; i < n; i++) {
    if (distance(dim, x + i * dim, from) < radius) continue;
    memmove(x + kept * dim, x + i * dim, (size_t)dim * sizeof *x);
    inside[kept++] = inside[i];
  }
  return kept;
}

/* Points on the rim of the hole, a spacing apart: a circle, or a spiral over the sphere (Vogel's
 * golden angle). Returns their number. */
static int64_t rim(int dim, double spacing, double *x) {
  const double pi = acos(-1);
  const double area = dim == 2 ? 2 * pi * HOLE / spacing : 4 * pi * pow(HOLE / spacing, 2);
  const int64_t count = (int64_t)ceil(area);
  for (int64_t k = 0; k < count; k++, x += dim) {
    const double z = dim == 2 ? 0 : 1 - (2 * (double)k + 1) / (double)count;
    const double turn = (double)k * (dim == 2 ? 2 * pi / (double)count : pi * (3 - sqrt(5)));
    const double ring = HOLE * sqrt(1 - z * z);
    x[0] = MIDDLE[0] + ring * cos(turn);
    x[1] = MIDDLE[1] + ring * sin(turn);
    if (dim == 3) x[2] = MIDDLE[2] + HOLE * z;
  }
  return count;
}

/* Gaps of 1.2 spacings in radius, at every sixth point of the lattice in each coordinate. Returns
 * how many points are left. */
static int64_t riddle(const fixture *whole, double *x, uint8_t *inside) {
  const int dim = whole->cloud.dim;
  const int64_t side = whole->lattice.cells[0] + 1;
  int64_t n = whole->cloud.n;
  for (int64_t i = 0; i < whole->cloud.n; i++) {
    bool is_gap = whole->inside[i] != 0;
    for (int64_t a = 0, rest = i; a < dim; a++, rest /= side) is_gap &= rest % side % 6 == 3;
    if (is_gap) n = bore(dim, n, whole->x + i * dim, 1.2 * whole->spacing, x, inside);
  }
  return n;
}

/* Where something is measured. */
typedef struct {
  int dim;
  int64_t cells;
  double jitter;
  uint64_t seed;
} site;

static fixture lattice_at(const site *at, const sct_operator *op) {
  return fixture_unit(at->dim, at->cells, at->jitter, at->seed, op);
}

typedef enum { VOID, RIM, GAPS } damage;

/* A jittered lattice with a void in it; with a hole, whose rim has points that are not inside and
 * come last; or with gaps. */
static fixture damaged(const site *at, const sct_operator *op, damage what) {
  fixture whole = lattice_at(at, op);
  const int dim = at->dim;
  const double h = whole.spacing;
  const int64_t room = whole.cloud.n + 100 * at->cells * at->cells;
  double *x = fixture_alloc(room * dim, sizeof *x);
  uint8_t *inside = fixture_alloc(room, 1);
  int64_t n = whole.cloud.n;
  memcpy(x, whole.x, (size_t)(n * dim) * sizeof *x);
  memcpy(inside, whole.inside, (size_t)n);
  if (what == GAPS) {
    n = riddle(&whole, x, inside);
  } else {
    n = bore(dim, n, MIDDLE, HOLE + (what == RIM ? 0.4 * h : 0), x, inside);
  }
  if (what == RIM) {
    const int64_t first = n;
    n += rim(dim, h, x + n * dim);
    memset(inside + first, 0, (size_t)(n - first));
  }
  fixture f = fixture_points(dim, n, x, h, op);
  memcpy(f.inside, inside, (size_t)n);
  fixture_clear(&whole);
  free(x);
  free(inside);
  return f;
}

/* --- what is measured ---------------------------------------------------------------------- */

/* Root mean square errors of gradient and Laplacian over the points of mask. */
static void operator_errors(const fixture *f, const uint8_t *mask, double error[2]) {
  const int dim = f->cloud.dim;
  const int64_t n = f->cloud.n;
  double *phi = fixture_alloc(n, sizeof *phi), *exact = fixture_alloc(n, sizeof *exact);
  double *lap = fixture_alloc(n, sizeof *lap), *grad = fixture_alloc(n * dim, sizeof *grad);
  double *slope = fixture_alloc(n * dim, sizeof *slope);
  sct_error err;
  for (int64_t i = 0; i < n; i++) {
    const truth t = truth_at(dim, f->x + i * dim, 0, 0);
    phi[i] = t.phi;
    exact[i] = t.laplacian;
    memcpy(slope + i * dim, t.gradient, (size_t)dim * sizeof *slope);
  }
  expect_ok(sct_stencil_apply(f->stencil, phi, NULL, NULL, grad, lap, &err), &err);
  error[0] = sct_norms_of(grad, slope, n, dim, mask).l2;
  error[1] = sct_norms_of(lap, exact, n, 1, mask).l2;
  double *const arrays[] = {phi, exact, lap, grad, slope};
  for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++) free(arrays[k]);
}

/* Each measure makes one cloud and tells one or two errors of it. */
typedef void measure(const site *at, const sct_operator *op, double *error);

/* Inside; and at the points of the boundary, corners and all. */
static void operators(const site *at, const sct_operator *op, double error[4]) {
  fixture f = lattice_at(at, op);
  operator_errors(&f, f.inside, error);
  for (int64_t i = 0; i < f.cloud.n; i++) f.inside[i] = !f.inside[i];
  operator_errors(&f, f.inside, error + 2);
  fixture_clear(&f);
}

/* At the points within two spacings of a void. */
static void operators_at_void(const site *at, const sct_operator *op, double error[2]) {
  fixture f = damaged(at, op, VOID);
  for (int64_t i = 0; i < f.cloud.n; i++) {
    f.inside[i] = distance(at->dim, f.x + i * at->dim, MIDDLE) < HOLE + 2 * f.spacing;
  }
  operator_errors(&f, f.inside, error);
  fixture_clear(&f);
}

static void steady(const site *at, const sct_operator *op, double *error) {
  fixture f = lattice_at(at, op);
  manufactured m = manufactured_new(&f, 0);
  *error = manufactured_steady(&m);
  manufactured_free(&m);
  fixture_clear(&f);
}

/* Crank-Nicolson with dt = h^2, of fourth order in h, so that space is what counts. The walls at
 * x = 1 and y = 1 are Robin and Neumann for lsmps; the one-sided slopes of the other schemes are of
 * first order and would hide what is compared. */
static void transient(const site *at, const sct_operator *op, double *error) {
  fixture f = lattice_at(at, op);
  manufactured m = manufactured_new(&f, 3);
  if (op->scheme == SCT_LSMPS) {
    manufactured_side(&m, SCT_SIDE_RIGHT, SCT_ROBIN);
    if (at->dim > 1) manufactured_side(&m, SCT_SIDE_TOP, SCT_NEUMANN);
  }
  *error = manufactured_in_time(&m, SCT_CRANK_NICOLSON, f.spacing * f.spacing, 0.05);
  manufactured_free(&m);
  fixture_clear(&f);
}

static void with_gaps(const site *at, const sct_operator *op, double *error) {
  fixture f = damaged(at, op, GAPS);
  manufactured m = manufactured_new(&f, 0);
  *error = manufactured_steady(&m);
  manufactured_free(&m);
  fixture_clear(&f);
}

/* Around a hole at whose rim the slope is given. */
static void around_hole(const site *at, const sct_operator *op, double *error) {
  fixture f = damaged(at, op, RIM);
  manufactured m = manufactured_new(&f, 0);
  for (int64_t i = 0; i < f.cloud.n; i++) {
    const double *x = f.x + i * at->dim;
    double normal[3];
    if (f.inside[i] || distance(at->dim, x, MIDDLE) > HOLE * (1 + 1e-9)) continue;
    for (int a = 0; a < at->dim; a++) normal[a] = (MIDDLE[a] - x[a]) / HOLE;
    manufactured_set(&m, i, SCT_NEUMANN, normal);
  }
  *error = manufactured_steady(&m);
  manufactured_free(&m);
  fixture_clear(&f);
}

/* --- what is expected ---------------------------------------------------------------------- */

enum { MOST = 4 };

static const struct {
  measure *error;
  int least_dim, errors;
  const char *name[MOST];
} MEASURES[] = {
    {operators, 1, 4, {"gradient", "Laplacian", "gradient, boundary", "Laplacian, boundary"}},
    {operators_at_void, 2, 2, {"gradient, rim of a void", "Laplacian, rim of a void"}},
    {steady, 1, 1, {"steady"}},
    {transient, 1, 1, {"transient"}},
    {with_gaps, 2, 1, {"steady, gaps"}},
    {around_hole, 2, 1, {"steady, hole"}},
};
enum { MEASURE_COUNT = sizeof MEASURES / sizeof *MEASURES };

/* Least and largest observed order, for each error of each measure, in 1-D, 2-D and 3-D. */
typedef struct {
  double low, high;
} range;

static const struct {
  const char *scheme;
  int degree;
  range order[MEASURE_COUNT][MOST];
} SCHEMES[] = {
    {"ps",
     2,
     {{{-0.3, 1.2}, {-1.3, -0.7}, {-0.3, 1.2}, {-1.3, -0.7}},
      {{-0.3, 0.3}, {-1.5, -0.7}},
      {{-0.1, 1.2}},
      {{0.0, 1.2}},
      {{0.0, 1.2}},
      {{-0.6, 1.2}}}},
    {"ips",
     2,
     {{{0.8, 1.3}, {-0.3, 0.3}, {0.8, 1.3}, {-0.3, 0.3}},
      {{0.5, 1.3}, {-0.6, 0.3}},
      {{-0.4, 1.1}},
      {{-0.4, 1.1}},
      {{-0.3, 1.0}},
      {{0.7, 2.2}}}},
    {"ipsn",
     2,
     {{{0.8, 1.3}, {-0.3, 1.2}, {0.8, 2.2}, {-0.3, 1.2}},
      {{0.5, 1.3}, {-0.6, 0.3}},
      {{1.5, 2.5}},
      {{1.5, 2.4}},
      {{1.0, 2.2}},
      {{0.5, 1.6}}}},
    {"lsmps",
     2,
     {{{1.8, 2.3}, {0.9, 1.7}, {1.8, 2.3}, {0.8, 1.4}},
      {{1.7, 2.4}, {0.5, 1.6}},
      {{1.7, 2.5}},
      {{1.6, 2.2}},
      {{1.7, 2.6}},
      {{1.9, 4.5}}}},
    {"lsmps",
     3,
     {{{2.8, 3.7}, {1.7, 2.3}, {2.8, 3.5}, {1.8, 2.4}},
      {{2.4, 3.6}, {1.4, 2.4}},
      {{1.8, 2.4}},
      {{1.7, 2.3}},
      {{1.7, 2.5}},
      {{1.6, 2.5}}}},
    {"lsmps",
     4,
     {{{3.7, 4.4}, {2.9, 3.9}, {3.2, 4.3}, {2.6, 3.3}},
      {{3.2, 4.6}, {1.9, 3.6}},
      {{3.7, 5.2}},
      {{3.4, 4.4}},
      {{3.3, 5.3}},
      {{3.5, 13}}}},
};
enum { SCHEME_COUNT = sizeof SCHEMES / sizeof *SCHEMES };

/* Errors of a measure at a site and the seeds that follow, means over clouds. */
static void mean_errors(measure *measured, const site *at, const sct_operator *op, double *mean) {
  const int clouds = at->jitter > 0 ? CLOUDS[at->dim] : 1;
  for (int e = 0; e < MOST; e++) mean[e] = 0;
  for (int cloud = 0; cloud < clouds; cloud++) {
    site here = *at;
    double error[MOST] = {0};
    here.seed += (uint64_t)cloud;
    measured(&here, op, error);
    for (int e = 0; e < MOST; e++) mean[e] += error[e] / clouds;
  }
}

/* Prints the orders of a scheme in a measure; how many are not as expected. */
static int judge(int m, int s, int dim, double error[MESHES][MOST]) {
  const double refined = (double)MESH[dim][MESHES - 1] / (double)MESH[dim][0];
  int wrong = 0;
  for (int e = 0; e < MEASURES[m].errors; e++) {
    const range expected = SCHEMES[s].order[m][e];
    const double order = log(error[0][e] / error[MESHES - 1][e]) / log(refined);
    const bool is_right = order >= expected.low && order <= expected.high;
    print_message("| %d-D | %-24s | %-5s %d | %.1e | %.1e | %.1e | %5.2f |%s\n", dim,
                  MEASURES[m].name[e], SCHEMES[s].scheme, SCHEMES[s].degree, error[0][e],
                  error[1][e], error[2][e], order, is_right ? "" : " not expected");
    wrong += !is_right;
  }
  return wrong;
}

static void observed_order(int dim) {
  int wrong = 0;
  for (int m = 0; m < MEASURE_COUNT; m++) {
    if (dim < MEASURES[m].least_dim) continue;
    for (int s = 0; s < SCHEME_COUNT; s++) {
      const sct_operator op =
          sct_operator_default(sct_scheme_find(SCHEMES[s].scheme), SCHEMES[s].degree);
      double error[MESHES][MOST];
      for (int k = 0; k < MESHES; k++) {
        const site at = {dim, MESH[dim][k], ALPHA, 100};
        mean_errors(MEASURES[m].error, &at, &op, error[k]);
      }
      wrong += judge(m, s, dim, error);
    }
  }
  assert_int_equal(wrong, 0);
}

static void one_dimension(void **state) {
  (void)state;
  observed_order(1);
}

static void two_dimensions(void **state) {
  (void)state;
  observed_order(2);
}

static void three_dimensions(void **state) {
  (void)state;
  observed_order(3);
}

/* Means over clouds drawn anew in every run, from a lattice to much disorder: Laplacian inside,
 * steady and transient solutions. On a lattice both are the same. */
static void ips_is_never_worse_than_ps(void **state) {
  static measure *const measures[] = {operators, steady, transient};
  static const int which[] = {1, 0, 0};
  static const double jitter[] = {0, 0.05, 0.1, 0.3, 0.5};
  const uint64_t seed = seed_new("verify.order");
  (void)state;
  for (int dim = 1; dim <= 3; dim++) {
    for (size_t a = 0; a < sizeof jitter / sizeof *jitter; a++) {
      for (int mesh = 0; mesh < MESHES - (dim > 1); mesh++) {
        for (size_t k = 0; k < sizeof measures / sizeof *measures; k++) {
          const site at = {dim, MESH[dim][mesh], jitter[a], seed};
          double ps[MOST], ips[MOST];
          const sct_operator old = sct_operator_default(SCT_PS, 2);
          const sct_operator improved = sct_operator_default(SCT_IPS, 2);
          mean_errors(measures[k], &at, &old, ps);
          mean_errors(measures[k], &at, &improved, ips);
          if (!(ips[which[k]] <= ps[which[k]] * (1 + 1e-6))) {
            fail_msg("%d-D, %d cells, alpha %g, measure %d: ips %g, ps %g", dim, (int)at.cells,
                     at.jitter, (int)k, ips[which[k]], ps[which[k]]);
          }
        }
      }
    }
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(one_dimension),
      cmocka_unit_test(two_dimensions),
      cmocka_unit_test(three_dimensions),
      cmocka_unit_test(ips_is_never_worse_than_ps),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
