/* verify.monotone: what each scheme guarantees and what it does not. Signs of the weights (an
 * M-matrix has none below zero), the maximum principle that follows, and which sums the exchange
 * between pairs of points conserves. Prints the table of lib/README.md. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fixture.h"
#include "seed.h"

static const int64_t CELLS[] = {0, 200, 30, 10};
static const double JITTER[] = {0, 0.1, 0.2, 0.3, 0.5};
enum { JITTERS = sizeof JITTER / sizeof *JITTER };

/* Laplacian rows of all inner points. */
static sct_system *laplace(const fixture *f, const double *value) {
  double *mu = fixture_alloc(f->cloud.n, sizeof *mu);
  uint8_t *condition = fixture_alloc(f->cloud.n, 1);
  sct_system *system = NULL;
  sct_error err;
  for (int64_t i = 0; i < f->cloud.n; i++) {
    mu[i] = 1;
    condition[i] = f->inside[i] ? SCT_INTERIOR : SCT_DIRICHLET;
  }
  const sct_fields fields = {.diffusivity = mu};
  const sct_boundary boundary = {.condition = condition, .value = value};
  expect_ok(sct_system_build(f->stencil, &fields, &boundary, NULL, &system, &err), &err);
  free(mu);
  free(condition);
  return system;
}

/* Entries of a row that have the wrong sign for an M-matrix, beyond 1e-6 of its size: kernel center
 * dips to -2e-8 just before q = 1. */
static int wrong_signs(const sct_csr *a, int64_t row, int64_t diagonal, double size) {
  int wrong = 0;
  for (int64_t k = a->start[row]; k < a->start[row + 1]; k++) {
    wrong += a->column[k] != diagonal && a->value[k] > 1e-6 * size;
  }
  return wrong;
}

/* Share of the rows that are not those of an M-matrix. */
static double share_of_wrong_rows(const fixture *f) {
  sct_system *s = laplace(f, NULL);
  const double size = 1 / (f->spacing * f->spacing);
  double wrong = 0;
  for (int64_t row = 0; row < s->unknowns; row++) {
    wrong += wrong_signs(s->matrix, row, row, size) + wrong_signs(s->coupling, row, -1, size) > 0;
  }
  wrong /= (double)s->unknowns;
  sct_system_free(&s);
  return wrong;
}

/* How far the solution of the Laplace equation leaves the range [0, 1] of random boundary values.
 */
static double excess(const fixture *f, uint64_t *random) {
  const int64_t n = f->cloud.n;
  const sct_solve_options options = {.dim = f->cloud.dim, .method = "auto"};
  double *value = fixture_alloc(n, sizeof *value), *b = fixture_alloc(n, sizeof *b);
  double *x = fixture_alloc(n, sizeof *x), worst = 0;
  sct_solver *solver = NULL;
  sct_error err;
  for (int64_t i = 0; i < n; i++) value[i] = seed_uniform(random, 0, 1) < 0.5 ? 0 : 1;
  sct_system *s = laplace(f, value);
  sct_system_rhs(s, value, b);
  expect_ok(sct_solver_analyse(s->matrix, &options, &solver, &err), &err);
  expect_ok(sct_solver_factor(solver, s->matrix, &err), &err);
  expect_ok(sct_solver_solve(solver, b, false, x, &err), &err);
  for (int64_t row = 0; row < s->unknowns; row++) {
    worst = fmax(worst, fmax(-x[row], x[row] - 1));
  }
  sct_solver_free(&solver);
  sct_system_free(&s);
  free(value);
  free(b);
  free(x);
  return worst;
}

/* Up to which jitter rows are those of an M-matrix, and up to which nearly all are. */
static const struct {
  const char *scheme;
  int degree;
  double all, most;
} SIGNS[] = {{"mps", 2, 0.5, 0.5},  {"ps", 2, 0.5, 0.5},    {"ips", 2, 0.1, 0.2},
             {"ipsn", 2, 0.1, 0.2}, {"lsmps", 2, 0.3, 0.5}, {"lsmps", 3, -1, -1},
             {"lsmps", 4, -1, -1}};

static void signs_and_maximum_principle(void **state) {
  uint64_t random = seed_new("verify.monotone");
  (void)state;
  for (size_t s = 0; s < sizeof SIGNS / sizeof *SIGNS; s++) {
    const sct_operator op = sct_operator_default(sct_scheme_find(SIGNS[s].scheme), SIGNS[s].degree);
    for (int dim = 1; dim <= 3; dim++) {
      print_message("| %-5s %d | %d-D |", SIGNS[s].scheme, SIGNS[s].degree, dim);
      for (int a = 0; a < JITTERS; a++) {
        fixture f = fixture_unit(dim, CELLS[dim], JITTER[a], seed_next(&random), &op);
        const double wrong = share_of_wrong_rows(&f), out = excess(&f, &random);
        print_message(" %.1f %%, %.0e |", 100 * wrong, out > 1e-10 ? out : 0);
        fixture_clear(&f);
        if (JITTER[a] <= SIGNS[s].all) assert_true(wrong == 0 && out < 1e-10);
        if (JITTER[a] <= SIGNS[s].most) assert_true(wrong < 0.05);
      }
      print_message("\n");
    }
  }
}

/* Largest |l_ij s_i - l_ji s_j| over pairs of inner points, times h^2, s = 1 or S_w. */
static double imbalance(const fixture *f, bool weigh) {
  const int64_t n = f->cloud.n;
  double *density = fixture_alloc(n, sizeof *density), worst = 0;
  sct_csr *l = NULL;
  sct_error err;
  const sct_diagnosis to = {.number_density = density};
  expect_ok(sct_diagnose(f->stencil, NULL, &to, &err), &err);
  sct_system *s = laplace(f, NULL);
  l = s->matrix;
  for (int64_t i = 0; i < s->unknowns; i++) {
    const double si = weigh ? density[s->point_of[i]] : 1;
    for (int64_t k = l->start[i]; k < l->start[i + 1]; k++) {
      const int32_t j = l->column[k];
      const double sj = weigh ? density[s->point_of[j]] : 1;
      double back = 0;
      for (int64_t m = l->start[j]; m < l->start[j + 1]; m++) {
        if (l->column[m] == i) back = l->value[m];
      }
      worst = fmax(worst, fabs(l->value[k] * si - back * sj));
    }
  }
  sct_system_free(&s);
  free(density);
  return worst * f->spacing * f->spacing;
}

/* What point i gives point j it loses itself: mps conserves sum phi_i, ps sum S_w phi_i; those that
 * correct the row at each point by itself conserve neither. */
static void exchange_between_pairs(void **state) {
  (void)state;
  for (int dim = 1; dim <= 3; dim++) {
    for (int scheme = SCT_MPS; scheme < SCT_SCHEME_COUNT; scheme++) {
      const sct_operator op = sct_operator_default(scheme, 2);
      fixture f = fixture_unit(dim, CELLS[dim], 0.3, 5, &op);
      const double plain = imbalance(&f, false), weighed = imbalance(&f, true);
      print_message("%-5s %d-D: exchange off by %.1e, weighed by S_w %.1e\n",
                    sct_scheme_name(scheme), dim, plain, weighed);
      assert_true((plain < 1e-11) == (scheme == SCT_MPS));
      assert_true((weighed < 1e-11) == (scheme == SCT_PS));
      fixture_clear(&f);
    }
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(signs_and_maximum_principle),
      cmocka_unit_test(exchange_between_pairs),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
