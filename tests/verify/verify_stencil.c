/* verify.stencil: exactness on polynomials, on lattices and on random clouds, in 1, 2, 3
 * dimensions, inside and at the boundary. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "fixture.h"

/* sum of c_m x^a y^b z^c over all monomials up to `degree`, with its gradient and Laplacian */
typedef struct {
  int dim, degree;
  double c[64];
} polynomial;

static double power(double x, int p) {
  return p < 0 ? 0 : pow(x, p);
}

static void evaluate(const polynomial *p, const double *x, double *value, double *gradient,
                     double *laplacian) {
  int m = 0;
  *value = *laplacian = 0;
  for (int a = 0; a < p->dim; a++) gradient[a] = 0;
  const double xs[3] = {x[0], p->dim > 1 ? x[1] : 1, p->dim > 2 ? x[2] : 1};
  for (int a = 0; a <= p->degree; a++) {
    for (int b = 0; b <= (p->dim > 1 ? p->degree - a : 0); b++) {
      for (int c = 0; c <= (p->dim > 2 ? p->degree - a - b : 0); c++, m++) {
        const int e[3] = {a, b, c};
        double term = p->c[m];
        for (int k = 0; k < p->dim; k++) term *= power(xs[k], e[k]);
        *value += term;
        for (int k = 0; k < p->dim; k++) {
          double rest = p->c[m];
          for (int l = 0; l < p->dim; l++) rest *= l == k ? 1 : power(xs[l], e[l]);
          gradient[k] += rest * e[k] * power(xs[k], e[k] - 1);
          *laplacian += rest * e[k] * (e[k] - 1) * power(xs[k], e[k] - 2);
        }
      }
    }
  }
}

static polynomial random_polynomial(int dim, int degree, uint64_t *state) {
  polynomial p = {.dim = dim, .degree = degree};
  for (int m = 0; m < 64; m++) p.c[m] = 2 * fixture_random(state) - 1;
  return p;
}

typedef struct {
  double gradient, laplacian; /* largest errors */
} errors;

/* Largest error of the operators on a polynomial; over interior points only if asked. */
static errors apply_error(const fixture *f, const polynomial *p, bool inside_only) {
  const int64_t n = f->cloud.n;
  const int dim = f->cloud.dim;
  double *field = fixture_alloc(n, sizeof *field), *lap = fixture_alloc(n, sizeof *lap);
  double *grad = fixture_alloc(n * dim, sizeof *grad);
  double value, g[3], l;
  errors worst = {0, 0};
  sct_error err;
  for (int64_t i = 0; i < n; i++) evaluate(p, f->x + i * dim, field + i, g, &l);
  expect_ok(sct_stencil_apply(f->stencil, field, NULL, NULL, grad, lap, &err), &err);
  for (int64_t i = 0; i < n; i++) {
    if (inside_only && !f->inside[i]) continue;
    evaluate(p, f->x + i * dim, &value, g, &l);
    worst.laplacian = fmax(worst.laplacian, fabs(lap[i] - l));
    for (int a = 0; a < dim; a++) {
      worst.gradient = fmax(worst.gradient, fabs(grad[i * dim + a] - g[a]));
    }
  }
  free(field);
  free(lap);
  free(grad);
  return worst;
}

static const int64_t CELLS[] = {0, 40, 14, 8};

typedef struct {
  const char *scheme, *weight;
  int degree; /* of the fit */
  double jitter;
  int exact_gradient; /* degree of polynomial */
  int exact_laplacian;
  bool inside_only;
} exactness;

static const exactness table[] = {
    {"mps", "kernel/r2", 2, 0.0, 1, 3, true},    {"ps", "kernel/r2", 2, 0.0, 1, 3, true},
    {"ips", "kernel/r2", 2, 0.5, 1, 1, false},   {"ipsn", "kernel/r2", 2, 0.5, 1, 1, false},
    {"lsmps", "kernel/r2", 2, 0.5, 2, 2, false}, {"lsmps", "kernel", 2, 0.5, 2, 2, false},
    {"lsmps", "kernel/r2", 3, 0.5, 3, 3, false}, {"lsmps", "kernel", 3, 0.3, 3, 3, false},
    {"lsmps", "kernel/r2", 4, 0.3, 4, 4, false},
};

static void check(const exactness *row, int dim, uint64_t seed) {
  sct_operator op = sct_operator_default(sct_scheme_find(row->scheme), row->degree);
  op.weight = sct_weight_find(row->weight);
  uint64_t random = seed;
  fixture f = fixture_unit(dim, CELLS[dim], row->jitter, seed, &op);
  const polynomial pg = random_polynomial(dim, row->exact_gradient, &random);
  const polynomial pl = random_polynomial(dim, row->exact_laplacian, &random);
  const double g = apply_error(&f, &pg, row->inside_only).gradient;
  const double l = apply_error(&f, &pl, row->inside_only).laplacian;
  const double tolerance = 1e-10 / (f.spacing * f.spacing);
  if (!(g < tolerance * f.spacing && l < tolerance)) {
    fail_msg("%s degree %d weight %s in %d-D, seed %d: gradient off by %g, Laplacian by %g",
             row->scheme, row->degree, row->weight, dim, (int)seed, g, l);
  }
  fixture_clear(&f);
}

static void exact_for_polynomials(void **state) {
  (void)state;
  for (size_t k = 0; k < sizeof table / sizeof table[0]; k++) {
    for (int dim = 1; dim <= 3; dim++) {
      for (uint64_t seed = 1; seed <= 3; seed++) check(&table[k], dim, seed);
    }
  }
}

/* A test that would pass with any rows proves nothing: the degree above must not be exact. */
static void not_exact_beyond(void **state) {
  (void)state;
  for (size_t k = 0; k < sizeof table / sizeof table[0]; k++) {
    sct_operator op = sct_operator_default(sct_scheme_find(table[k].scheme), table[k].degree);
    uint64_t random = 5;
    fixture f = fixture_unit(2, CELLS[2], 0.3, 5, &op);
    const polynomial p = random_polynomial(2, table[k].exact_laplacian + 1, &random);
    assert_true(apply_error(&f, &p, true).laplacian > 1e-4);
    fixture_clear(&f);
  }
}

/* Fully random points, no lattice behind them. (In 1-D some have no neighbour on one side.) */
static void exact_on_random_points(void **state) {
  (void)state;
  for (int dim = 2; dim <= 3; dim++) {
    const int64_t n = 1500;
    uint64_t random = 99;
    double *x = fixture_alloc(n * dim, sizeof *x);
    for (int64_t k = 0; k < n * dim; k++) x[k] = fixture_random(&random);
    sct_operator op = sct_operator_default(SCT_LSMPS, 2);
    const double spacing = pow((double)n, -1.0 / dim);
    fixture f = fixture_points(dim, n, x, spacing, &op);
    const polynomial linear = random_polynomial(dim, 1, &random);
    const errors e = apply_error(&f, &linear, false); /* fallback rows are exact for these too */
    assert_true(e.gradient < 1e-7 && e.laplacian < 1e-5);
    fixture_clear(&f);
    free(x);
  }
}

/* In one dimension a one-sided fit of degree 2 through two points is (1, -2, 1)-like: compare a
 * row with weights worked out by hand. Points 0, 1, 2.5 around 0: phi = x^2 has l = 2. */
static void three_points_by_hand(void **state) {
  (void)state;
  const double x[] = {-1, 0, 1.5};
  sct_operator op = sct_operator_default(SCT_IPS, 2);
  fixture f = fixture_points(1, 3, x, 1, &op);
  sct_room *room = NULL;
  sct_row row;
  sct_error err;
  expect_ok(sct_room_new(f.stencil, &room, &err), &err);
  expect_ok(sct_stencil_row(f.stencil, 1,
                            &(const sct_row_request){.want = SCT_ROW_LAPLACIAN | SCT_ROW_GRADIENT},
                            room, &row, &err),
            &err);
  /* w = 2/r - 1: w1 = 1, w2 = 1/3; S = 4/3; o = -1 + (1/3)/1.5; M = S in one dimension */
  const double w[2] = {1, 1.0 / 3}, r[2] = {-1, 1.5}, S = 4.0 / 3;
  const double o = w[0] / r[0] + w[1] / r[1];
  for (int64_t k = 0; k < 2; k++) {
    const int j = row.index[k] == 0 ? 0 : 1;
    const double l = 2 / S * w[j] / (r[j] * r[j]) * (1 - o * r[j] / S);
    assert_true(fabs(row.laplacian[k] - l) < 1e-13);
    assert_true(fabs(row.gradient[k] - w[j] / r[j] / S) < 1e-13);
  }
  sct_room_free(&room);
  fixture_clear(&f);
}

/* The smoothed value of a constant is the constant; of a linear function on a lattice its own. */
static void smoothing(void **state) {
  (void)state;
  const sct_operator op = sct_operator_default(SCT_PS, 2);
  fixture f = fixture_unit(2, 10, 0, 1, &op);
  double *field = fixture_alloc(f.cloud.n, sizeof *field);
  double *smoothed = fixture_alloc(f.cloud.n, sizeof *smoothed);
  sct_error err;
  for (int64_t i = 0; i < f.cloud.n; i++) field[i] = 3 + f.x[2 * i] - 2 * f.x[2 * i + 1];
  expect_ok(sct_stencil_apply(f.stencil, field, NULL, smoothed, NULL, NULL, &err), &err);
  for (int64_t i = 0; i < f.cloud.n; i++) {
    if (f.inside[i]) assert_true(fabs(smoothed[i] - field[i]) < 1e-13);
  }
  free(field);
  free(smoothed);
  fixture_clear(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(exact_for_polynomials),
      cmocka_unit_test(not_exact_beyond),
      cmocka_unit_test(exact_on_random_points),
      cmocka_unit_test(three_points_by_hand),
      cmocka_unit_test(smoothing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
