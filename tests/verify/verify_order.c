/* verify.order: observed order of every scheme on jittered clouds (alpha = 0.3), means over clouds:
 * gradient and Laplacian inside, where neighbourhoods are one-sided, and next to holes; steady and
 * transient manufactured problems. Prints the tables of lib/README.md. Besides what has to converge,
 * the table says what must not: that ps gets worse and ips stalls is as much a statement of the
 * documentation as that lsmps converges. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "manufactured.h"

enum { CLOUDS = 4, MESHES = 3 };
static const double ALPHA = 0.3;
static const int64_t MESH[][MESHES] = {{0}, {20, 40, 80}, {12, 24, 48}, {6, 10, 16}};

/* --- clouds -------------------------------------------------------------------------------- */

static const double CENTER = 0.47, HOLE = 0.23;

static double distance(int dim, const double *x) {
  double r2 = 0;
  for (int a = 0; a < dim; a++) r2 += (x[a] - CENTER) * (x[a] - CENTER);
  return sqrt(r2);
}

/* Keeps the points outside of a ball; `inside` goes with them. Returns their number. */
static int64_t bore(int dim, int64_t n, double radius, double *x, uint8_t *inside) {
  int64_t kept = 0;
  for (int64_t i = 0; i < n; i++) {
    if (distance(dim, x + i * dim) < radius) continue;
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
    x[0] = CENTER + HOLE * sqrt(1 - z * z) * cos(turn);
    x[1] = CENTER + HOLE * sqrt(1 - z * z) * sin(turn);
    if (dim == 3) x[2] = CENTER + HOLE * z;
  }
  return count;
}

/* A jittered lattice with a hole: a void in it, or one with points on its rim (which count as not
 * inside and follow `*first`). */
static fixture holed(int dim, int64_t cells, uint64_t seed, const sct_operator *op, bool has_rim,
                     int64_t *first) {
  const fixture whole = fixture_unit(dim, cells, ALPHA, seed, op);
  double *x = fixture_alloc((whole.cloud.n + 100 * cells * cells) * dim, sizeof *x);
  uint8_t *inside = fixture_alloc(whole.cloud.n + 100 * cells * cells, 1);
  memcpy(x, whole.x, (size_t)(whole.cloud.n * dim) * sizeof *x);
  memcpy(inside, whole.inside, (size_t)whole.cloud.n);
  const double spacing = whole.spacing;
  *first = bore(dim, whole.cloud.n, HOLE + (has_rim ? 0.4 * spacing : 0), x, inside);
  const int64_t n = *first + (has_rim ? rim(dim, spacing, x + *first * dim) : 0);
  fixture f = fixture_points(dim, n, x, spacing, op);
  memcpy(f.inside, inside, (size_t)n);
  fixture_clear((fixture *)&whole);
  free(x);
  free(inside);
  return f;
}

/* --- what is measured ---------------------------------------------------------------------- */

/* Errors of gradient and Laplacian, evaluated, over the points of mask. */
static void operator_errors(const fixture *f, const uint8_t *mask, double *gradient,
                            double *laplacian) {
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
  *gradient = sct_norms_of(grad, slope, n, dim, mask).l2;
  *laplacian = sct_norms_of(lap, exact, n, 1, mask).l2;
  double *const arrays[] = {phi, exact, lap, grad, slope};
  for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++) free(arrays[k]);
}

/* Each measure makes one cloud and returns one error of it. */
typedef double measure(int dim, int64_t cells, uint64_t seed, const sct_operator *op);

static double gradient_inside(int dim, int64_t cells, uint64_t seed, const sct_operator *op) {
  fixture f = fixture_unit(dim, cells, ALPHA, seed, op);
  double gradient, laplacian;
  operator_errors(&f, f.inside, &gradient, &laplacian);
  fixture_clear(&f);
  return gradient;
}

static double laplacian_inside(int dim, int64_t cells, uint64_t seed, const sct_operator *op) {
  fixture f = fixture_unit(dim, cells, ALPHA, seed, op);
  double gradient, laplacian;
  operator_errors(&f, f.inside, &gradient, &laplacian);
  fixture_clear(&f);
  return laplacian;
}

/* At the points of the boundary, corners and all. */
static void one_sided(int dim, int64_t cells, uint64_t seed, const sct_operator *op,
                      double *gradient, double *laplacian) {
  fixture f = fixture_unit(dim, cells, ALPHA, seed, op);
  for (int64_t i = 0; i < f.cloud.n; i++) f.inside[i] = !f.inside[i];
  operator_errors(&f, f.inside, gradient, laplacian);
  fixture_clear(&f);
}

static double gradient_one_sided(int dim, int64_t cells, uint64_t seed, const sct_operator *op) {
  double gradient, laplacian;
  one_sided(dim, cells, seed, op, &gradient, &laplacian);
  return gradient;
}

static double laplacian_one_sided(int dim, int64_t cells, uint64_t seed, const sct_operator *op) {
  double gradient, laplacian;
  one_sided(dim, cells, seed, op, &gradient, &laplacian);
  return laplacian;
}

static double steady(int dim, int64_t cells, uint64_t seed, const sct_operator *op) {
  fixture f = fixture_unit(dim, cells, ALPHA, seed, op);
  manufactured m = manufactured_new(&f, 0);
  const double error = manufactured_steady(&m);
  manufactured_free(&m);
  fixture_clear(&f);
  return error;
}

/* Crank-Nicolson with dt proportional to h^2: of fourth order in h, so that space is what counts.
 * The walls at x = 1 and y = 1 are Robin and Neumann for lsmps; the one-sided slopes of the other
 * schemes are of first order and would hide what is compared. */
static double transient(int dim, int64_t cells, uint64_t seed, const sct_operator *op) {
  fixture f = fixture_unit(dim, cells, ALPHA, seed, op);
  manufactured m = manufactured_new(&f, 3);
  if (op->scheme == SCT_LSMPS) {
    manufactured_side(&m, SCT_SIDE_RIGHT, SCT_ROBIN);
    if (dim > 1) manufactured_side(&m, SCT_SIDE_TOP, SCT_NEUMANN);
  }
  const double error =
      manufactured_in_time(&m, SCT_CRANK_NICOLSON, f.spacing * f.spacing, 0.05);
  manufactured_free(&m);
  fixture_clear(&f);
  return error;
}

/* A void in the cloud, over which the equation holds as everywhere. */
static double across_void(int dim, int64_t cells, uint64_t seed, const sct_operator *op) {
  int64_t first;
  fixture f = holed(dim, cells, seed, op, false, &first);
  manufactured m = manufactured_new(&f, 0);
  const double error = manufactured_steady(&m);
  manufactured_free(&m);
  fixture_clear(&f);
  return error;
}

/* A hole with a rim that has a slope. */
static double around_hole(int dim, int64_t cells, uint64_t seed, const sct_operator *op) {
  int64_t first;
  fixture f = holed(dim, cells, seed, op, true, &first);
  manufactured m = manufactured_new(&f, 0);
  for (int64_t i = first; i < f.cloud.n; i++) {
    double normal[3] = {0, 0, 0};
    const double *x = f.x + i * dim;
    for (int a = 0; a < dim; a++) normal[a] = (CENTER - x[a]) / HOLE;
    manufactured_set(&m, i, SCT_NEUMANN, normal);
  }
  const double error = manufactured_steady(&m);
  manufactured_free(&m);
  fixture_clear(&f);
  return error;
}

/* --- what is expected ---------------------------------------------------------------------- */

typedef struct {
  const char *name;
  measure *error;
  int dims; /* from this dimension on */
} quantity;

static const quantity QUANTITIES[] = {
    {"gradient", gradient_inside, 1},
    {"Laplacian", laplacian_inside, 1},
    {"gradient, one-sided", gradient_one_sided, 1},
    {"Laplacian, one-sided", laplacian_one_sided, 1},
    {"steady", steady, 1},
    {"transient", transient, 1},
    {"steady across a void", across_void, 2},
    {"steady around a hole", around_hole, 2},
};
enum { QUANTITY_COUNT = sizeof QUANTITIES / sizeof *QUANTITIES };

typedef struct {
  double low, high; /* of the observed order */
} range;

static const struct {
  const char *scheme;
  int degree;
  range order[QUANTITY_COUNT];
} SCHEMES[] = {
    {"ps", 2, {{-9, 9}, {-9, 9}, {-9, 9}, {-9, 9}, {-9, 9}, {-9, 9}, {-9, 9}, {-9, 9}}},
    {"ips", 2, {{-9, 9}, {-9, 9}, {-9, 9}, {-9, 9}, {-9, 9}, {-9, 9}, {-9, 9}, {-9, 9}}},
    {"ipsn", 2, {{-9, 9}, {-9, 9}, {-9, 9}, {-9, 9}, {-9, 9}, {-9, 9}, {-9, 9}, {-9, 9}}},
    {"lsmps", 2, {{-9, 9}, {-9, 9}, {-9, 9}, {-9, 9}, {-9, 9}, {-9, 9}, {-9, 9}, {-9, 9}}},
    {"lsmps", 3, {{-9, 9}, {-9, 9}, {-9, 9}, {-9, 9}, {-9, 9}, {-9, 9}, {-9, 9}, {-9, 9}}},
    {"lsmps", 4, {{-9, 9}, {-9, 9}, {-9, 9}, {-9, 9}, {-9, 9}, {-9, 9}, {-9, 9}, {-9, 9}}},
};
enum { SCHEME_COUNT = sizeof SCHEMES / sizeof *SCHEMES };

static double mean_error(measure *error, int dim, int64_t cells, const sct_operator *op) {
  double sum = 0;
  for (uint64_t seed = 0; seed < CLOUDS; seed++) sum += error(dim, cells, 100 + seed, op);
  return sum / CLOUDS;
}

static void observed_order(int dim) {
  int wrong = 0;
  const double refined = (double)MESH[dim][MESHES - 1] / (double)MESH[dim][0];
  for (int q = 0; q < QUANTITY_COUNT; q++) {
    if (dim < QUANTITIES[q].dims) continue;
    for (int s = 0; s < SCHEME_COUNT; s++) {
      const sct_operator op =
          sct_operator_default(sct_scheme_find(SCHEMES[s].scheme), SCHEMES[s].degree);
      double error[MESHES];
      for (int m = 0; m < MESHES; m++) {
        error[m] = mean_error(QUANTITIES[q].error, dim, MESH[dim][m], &op);
      }
      const double order = log(error[0] / error[MESHES - 1]) / log(refined);
      const range expected = SCHEMES[s].order[q];
      const bool is_right = order >= expected.low && order <= expected.high;
      wrong += !is_right;
      print_message("| %d-D | %s | %s %d | %.1e | %.1e | %.1e | %.2f |%s\n", dim,
                    QUANTITIES[q].name, SCHEMES[s].scheme, SCHEMES[s].degree, error[0], error[1],
                    error[2], order, is_right ? "" : " WRONG");
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

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(one_dimension),
      cmocka_unit_test(two_dimensions),
      cmocka_unit_test(three_dimensions),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
