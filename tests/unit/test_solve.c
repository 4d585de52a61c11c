/* Every row of the table of solvers through the same tests, against elimination in long double. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "../dense.h"
#include "../near.h"
#include "../seed.h"
#include "scatter/solve.h"

enum { N = 60, KINDS_MAX = 16 };

/* Rows of the table that factor; the iterative one has test_solve_petsc.c. */
static const char *direct_name(int k) {
  const char *name = sct_solver_name(k);
  return name != NULL && strcmp(name, "iterative") != 0 ? name : NULL;
}

typedef struct {
  double full[N * N];
  sct_csr *a;
  double b[N], x[N], exact[N];
} problem;

/* About five entries a row, rows dominated by the diagonal. */
static void fill_dominant(problem *p, uint64_t *seed) {
  memset(p->full, 0, sizeof p->full);
  for (int i = 0; i < N; i++) {
    double sum = 0;
    for (int k = 0; k < 4; k++) {
      const double v = seed_uniform(seed, -1, 1);
      p->full[i * N + seed_below(seed, N)] = v;
    }
    for (int j = 0; j < N; j++) sum += fabs(p->full[i * N + j]);
    p->full[i * N + i] = 1.1 * sum + 0.1;
    p->b[i] = seed_uniform(seed, -1, 1);
  }
}

static void shuffle_rows(problem *p, uint64_t *seed) {
  for (int i = N - 1; i > 0; i--) {
    const int other = seed_below(seed, i + 1);
    for (int j = 0; j < N; j++) {
      const double t = p->full[i * N + j];
      p->full[i * N + j] = p->full[other * N + j];
      p->full[other * N + j] = t;
    }
  }
}

/* Condition rows among equation rows: 1 beside 1e9. */
static void scale_rows(problem *p, uint64_t *seed) {
  for (int i = 0; i < N; i++) {
    const double factor = seed_below(seed, 2) ? 1e9 : 1;
    for (int j = 0; j < N; j++) p->full[i * N + j] *= factor;
    p->b[i] *= factor;
  }
}

static void oracle(problem *p, bool transposed) {
  double t[N * N];
  for (int i = 0; i < N; i++) {
    for (int j = 0; j < N; j++) t[j * N + i] = p->full[i * N + j];
  }
  assert_true(dense_solve(transposed ? t : p->full, N, p->b, p->exact));
}

static void expect_solution(problem *p, sct_solver *solver, bool transposed, double tolerance) {
  sct_error err = {0};
  oracle(p, transposed);
  sct_status status = sct_solver_solve(solver, p->b, transposed, p->x, &err);
  if (status != SCT_OK) fail_msg("%s: %s", sct_solver_report(solver)->method, err.text);
  double scale = 0;
  for (int i = 0; i < N; i++) scale = fmax(scale, fabs(p->exact[i]));
  for (int i = 0; i < N; i++) assert_near(p->x[i], p->exact[i], tolerance * scale);
  assert_true(sct_solver_report(solver)->residual < 1e-14);
}

/* Analyses, factors and solves with A and its transpose by every solver of the table. */
static void run_all(problem *p, double tolerance) {
  const int64_t entries = sct_csr_entries(p->a = dense_to_csr(p->full, N, N));
  for (int k = 0; direct_name(k) != NULL; k++) {
    sct_error err = {0};
    sct_solver *solver = NULL;
    const sct_solve_options options = {.dim = 2, .method = direct_name(k)};
    assert_int_equal(sct_solver_analyse(p->a, &options, &solver, &err), SCT_OK);
    if (sct_solver_factor(solver, p->a, &err) != SCT_OK) fail_msg("%s", err.text);
    expect_solution(p, solver, false, tolerance);
    expect_solution(p, solver, true, tolerance);
    const sct_solve_report *report = sct_solver_report(solver);
    assert_string_equal(report->method, options.method);
    assert_int_equal(report->rows, N);
    assert_int_equal(report->nonzeros, entries);
    assert_true(report->factor_nonzeros >= N);
    assert_true(report->peak_bytes > 0);
    assert_true(report->reciprocal_condition > 1e-6 && report->reciprocal_condition <= 1);
    assert_true(report->seconds_factor > 0 && report->seconds_solve > 0);
    assert_non_null(report->ordering);
    sct_solver_free(&solver);
    assert_null(solver);
  }
  sct_csr_free(&p->a);
}

static void dominant(void **state) {
  (void)state;
  problem p;
  uint64_t seed = seed_new("dominant");
  fill_dominant(&p, &seed);
  run_all(&p, 1e-14);
}

static void rows_permuted(void **state) {
  (void)state;
  problem p;
  uint64_t seed = seed_new("rows_permuted");
  fill_dominant(&p, &seed);
  shuffle_rows(&p, &seed);
  run_all(&p, 1e-14);
}

static void rows_badly_scaled(void **state) {
  (void)state;
  problem p;
  uint64_t seed = seed_new("rows_badly_scaled");
  fill_dominant(&p, &seed);
  scale_rows(&p, &seed);
  run_all(&p, 1e-9); /* the transposed solution is as badly scaled as the rows */
}

static void factored_anew(void **state) {
  (void)state;
  uint64_t seed = seed_new("factored_anew");
  for (int k = 0; direct_name(k) != NULL; k++) {
    problem p;
    sct_error err = {0};
    sct_solver *solver = NULL;
    fill_dominant(&p, &seed);
    p.a = dense_to_csr(p.full, N, N);
    const sct_solve_options options = {.dim = 2, .method = direct_name(k)};
    assert_int_equal(sct_solver_analyse(p.a, &options, &solver, &err), SCT_OK);
    for (int round = 0; round < 3; round++) {
      assert_int_equal(sct_solver_factor(solver, p.a, &err), SCT_OK);
      expect_solution(&p, solver, round == 1, 1e-14);
      for (int j = 0; j < N * N; j++) {
        if (p.full[j] != 0) p.full[j] += p.full[j] > 1 ? 1 : seed_uniform(&seed, -0.1, 0.1);
      }
      sct_csr_free(&p.a);
      p.a = dense_to_csr(p.full, N, N);
    }
    sct_solver_free(&solver);
    sct_csr_free(&p.a);
  }
}

/* The status of analyse and factor together, text in err. */
static sct_status factor_status(const sct_csr *a, const char *method, sct_error *err) {
  sct_solver *solver = NULL;
  const sct_solve_options options = {.dim = 2, .method = method};
  sct_status status = sct_solver_analyse(a, &options, &solver, err);
  if (status == SCT_OK) status = sct_solver_factor(solver, a, err);
  sct_solver_free(&solver);
  return status;
}

static void expect_status(const double *full, int n, sct_status expected) {
  sct_csr *a = dense_to_csr(full, n, n);
  for (int k = 0; direct_name(k) != NULL; k++) {
    sct_error err = {0};
    const sct_status status = factor_status(a, direct_name(k), &err);
    if (status != expected) fail_msg("%s: status %s", direct_name(k), sct_status_name(status));
    assert_int_equal(err.code, expected);
    assert_int_equal(err.point, -1);
    assert_true(strlen(err.text) > 10);
  }
  sct_csr_free(&a);
}

static void failed_factors_do_not_solve(void **state) {
  (void)state;
  sct_csr *good = dense_to_csr((const double[]){1, 2, 3, 4}, 2, 2);
  sct_csr *bad = dense_to_csr((const double[]){1, 2, 2, 4}, 2, 2);
  for (int k = 0; direct_name(k) != NULL; k++) {
    sct_solver *solver = NULL;
    double x[2];
    const double b[] = {5, 11};
    const sct_solve_options options = {.dim = 2, .method = direct_name(k)};
    assert_int_equal(sct_solver_analyse(good, &options, &solver, NULL), SCT_OK);
    assert_int_equal(sct_solver_factor(solver, good, NULL), SCT_OK);
    assert_int_equal(sct_solver_factor(solver, bad, NULL), SCT_E_SINGULAR);
    assert_int_equal(sct_solver_solve(solver, b, false, x, NULL), SCT_E_ARGUMENT);
    assert_int_equal(sct_solver_factor(solver, good, NULL), SCT_OK);
    assert_int_equal(sct_solver_solve(solver, b, false, x, NULL), SCT_OK);
    assert_near(x[0], 1, 1e-14);
    assert_near(x[1], 2, 1e-14);
    sct_solver_free(&solver);
  }
  sct_csr_free(&bad);
  sct_csr_free(&good);
}

/* As many entries, but elsewhere: in other columns, in other rows. */
static void another_pattern(void **state) {
  (void)state;
  const double analysed[] = {1, 2, 0, 0, 3, 4, 5, 0, 6};
  const double others[][9] = {{1, 0, 2, 0, 3, 4, 5, 0, 6}, {1, 0, 0, 2, 3, 4, 0, 5, 6}};
  sct_csr *a = dense_to_csr(analysed, 3, 3);
  for (int k = 0; direct_name(k) != NULL; k++) {
    sct_solver *solver = NULL;
    const sct_solve_options options = {.dim = 2, .method = direct_name(k)};
    assert_int_equal(sct_solver_analyse(a, &options, &solver, NULL), SCT_OK);
    for (int c = 0; c < 2; c++) {
      sct_csr *other = dense_to_csr(others[c], 3, 3);
      assert_int_equal(sct_csr_entries(other), sct_csr_entries(a));
      assert_int_equal(sct_solver_factor(solver, other, NULL), SCT_E_ARGUMENT);
      sct_csr_free(&other);
    }
    /* the same columns one after the other, cut into rows elsewhere */
    a->start[1] = 1;
    assert_int_equal(sct_solver_factor(solver, a, NULL), SCT_E_ARGUMENT);
    a->start[1] = 2;
    assert_int_equal(sct_solver_factor(solver, a, NULL), SCT_OK);
    sct_solver_free(&solver);
  }
  sct_csr_free(&a);
}

static void singular_by_value(void **state) {
  (void)state;
  const double twice[] = {1, 2, 3, 2, 4, 6, 1, 0, 1};
  expect_status(twice, 3, SCT_E_SINGULAR);
}

/* -u'' with a flux at both ends: singular, but every pivot is rounded. */
static void singular_by_rounding(void **state) {
  (void)state;
  uint64_t seed = seed_new("singular_by_rounding");
  for (int round = 0; round < 20; round++) {
    double full[N * N] = {0};
    for (int i = 0; i + 1 < N; i++) {
      const double left = seed_uniform(&seed, 0.1, 1), right = seed_uniform(&seed, 0.1, 1);
      full[i * N + i] += left;
      full[i * N + i + 1] -= left;
      full[(i + 1) * N + i + 1] += right;
      full[(i + 1) * N + i] -= right;
    }
    expect_status(full, N, SCT_E_SINGULAR);
  }
}

static void singular_by_structure(void **state) {
  (void)state;
  const double narrow[] = {1, 1, 0, 1, 1, 0, 1, 1, 1, 0, 0, 0, 1, 1, 1, 1};
  double full[16];
  memcpy(full, narrow, sizeof full);
  full[8] = full[9] = 0; /* columns 0, 1 in two rows, and a last row 1 1 1 1 */
  full[2] = 0;
  expect_status((const double[]){1, 0, 0, 2, 0, 0, 3, 1, 1}, 3, SCT_E_SINGULAR);
  expect_status(full, 4, SCT_E_SINGULAR);
}

static void zero_row(void **state) {
  (void)state;
  expect_status((const double[]){1, 1, 0, 0}, 2, SCT_E_SINGULAR);
  sct_csr *a = dense_to_csr((const double[]){1, 1, 1, 2}, 2, 2);
  a->value[2] = a->value[3] = 0;
  for (int k = 0; direct_name(k) != NULL; k++) {
    sct_error err;
    assert_int_equal(factor_status(a, direct_name(k), &err), SCT_E_SINGULAR);
    assert_non_null(strstr(err.text, "row 1"));
  }
  sct_csr_free(&a);
}

static void one_by_one(void **state) {
  (void)state;
  sct_csr *a = dense_to_csr((const double[]){-4e-200}, 1, 1);
  for (int k = 0; direct_name(k) != NULL; k++) {
    sct_solver *solver = NULL;
    double x = 0;
    const sct_solve_options options = {.dim = 1, .method = direct_name(k)};
    assert_int_equal(sct_solver_analyse(a, &options, &solver, NULL), SCT_OK);
    assert_int_equal(sct_solver_factor(solver, a, NULL), SCT_OK);
    assert_int_equal(sct_solver_solve(solver, (const double[]){8e-200}, k % 2, &x, NULL), SCT_OK);
    assert_near(x, -2, 1e-15);
    assert_near(sct_solver_report(solver)->reciprocal_condition, 1, 1e-15);
    sct_solver_free(&solver);
  }
  sct_csr_free(&a);
}

static void not_finite(void **state) {
  (void)state;
  expect_status((const double[]){1, NAN, 2, 5}, 2, SCT_E_NOT_FINITE);
  expect_status((const double[]){1, 3, -INFINITY, 5}, 2, SCT_E_NOT_FINITE);
  sct_csr *a = dense_to_csr((const double[]){1, 2, 3, 4}, 2, 2);
  sct_solver *solver = NULL;
  double x[2];
  sct_error err;
  assert_int_equal(sct_solver_analyse(a, NULL, &solver, &err), SCT_OK);
  assert_int_equal(sct_solver_factor(solver, a, &err), SCT_OK);
  assert_int_equal(sct_solver_solve(solver, (const double[]){NAN, 1}, false, x, &err),
                   SCT_E_NOT_FINITE);
  assert_int_equal(sct_solver_solve(solver, (const double[]){1e308, -1e308}, false, x, &err),
                   SCT_E_SINGULAR); /* the exact solution is beyond double */
  sct_solver_free(&solver);
  sct_csr_free(&a);
}

static void arguments(void **state) {
  (void)state;
  sct_error err;
  sct_solver *solver = (sct_solver *)&err;
  sct_csr *wide = dense_to_csr((const double[]){1, 2, 3, 4, 5, 6}, 2, 3);
  assert_int_equal(sct_solver_analyse(wide, NULL, &solver, &err), SCT_E_ARGUMENT);
  assert_null(solver);
  assert_non_null(strstr(err.text, "2 x 3"));
  sct_csr *square = dense_to_csr((const double[]){1, 2, 3, 4}, 2, 2);
  const sct_solve_options unknown = {.dim = 2, .method = "magic"};
  assert_int_equal(sct_solver_analyse(square, &unknown, &solver, &err), SCT_E_ARGUMENT);
  assert_non_null(strstr(err.text, "iterative"));
  for (int k = 0; direct_name(k) != NULL; k++) {
    assert_non_null(strstr(err.text, direct_name(k)));
  }
  double x[2];
  assert_int_equal(sct_solver_analyse(square, NULL, &solver, &err), SCT_OK);
  assert_int_equal(sct_solver_solve(solver, x, false, x, &err), SCT_E_ARGUMENT);
  sct_csr *other = dense_to_csr((const double[]){1, 0, 3, 4}, 2, 2);
  assert_int_equal(sct_solver_factor(solver, other, &err), SCT_E_ARGUMENT);
  sct_csr *empty = NULL;
  assert_int_equal(sct_csr_new(0, 0, 0, &empty, NULL), SCT_OK);
  sct_solver_free(&solver);
  assert_int_equal(sct_solver_analyse(empty, NULL, &solver, &err), SCT_E_ARGUMENT);
  sct_csr_free(&empty);
  sct_csr_free(&other);
  sct_csr_free(&square);
  sct_csr_free(&wide);
  assert_null(sct_solver_name(-1));
}

/* Columns out of range, unsorted or twice do not get into a package. */
static void broken_patterns(void **state) {
  (void)state;
  const int32_t columns[][4] = {{0, 1, 0, 2}, {0, 1, 0, -1}, {1, 0, 0, 1}, {0, 0, 0, 1}};
  for (size_t c = 0; c < sizeof columns / sizeof *columns; c++) {
    sct_csr *a = dense_to_csr((const double[]){1, 2, 3, 4}, 2, 2);
    memcpy(a->column, columns[c], sizeof columns[c]);
    for (int k = 0; direct_name(k) != NULL; k++) {
      assert_int_equal(factor_status(a, direct_name(k), NULL), SCT_E_ARGUMENT);
    }
    sct_csr_free(&a);
  }
}

/* The estimate is Skeel's condition number, whatever the scale of the rows. */
static void condition_number(void **state) {
  (void)state;
  const double full[] = {2, -1, 0, -1e6, 2e6, -1e6, 0, -1e-6, 2e-6};
  /* A^-1 = 1/4 [3 2 1; 2 4 2; 1 2 3], |A| e = (3, 4, 3): largest row sum 28/4 */
  sct_csr *a = dense_to_csr(full, 3, 3);
  for (int k = 0; direct_name(k) != NULL; k++) {
    sct_solver *solver = NULL;
    const sct_solve_options options = {.dim = 0, .method = direct_name(k)};
    assert_int_equal(sct_solver_analyse(a, &options, &solver, NULL), SCT_OK);
    assert_int_equal(sct_solver_factor(solver, a, NULL), SCT_OK);
    assert_near(sct_solver_report(solver)->reciprocal_condition, 1 / 7., 1e-14);
    sct_solver_free(&solver);
  }
  sct_csr_free(&a);
}

/* || |A^-1| |A| e ||, row by row of the inverse. */
static double skeel(const double *full, int n) {
  double t[N * N], e[N], row[N], worst = 0;
  for (int i = 0; i < n; i++) {
    for (int j = 0; j < n; j++) t[j * n + i] = full[i * n + j];
  }
  for (int k = 0; k < n; k++) {
    double sum = 0;
    memset(e, 0, sizeof e);
    e[k] = 1;
    assert_true(dense_solve(t, n, e, row));
    for (int i = 0; i < n; i++) {
      for (int j = 0; j < n; j++) sum += fabs(row[i]) * fabs(full[i * n + j]);
    }
    worst = fmax(worst, sum);
  }
  return worst;
}

/* Of matrices with entries of both signs it is an estimate from below, mostly a close one. */
static void condition_estimate(void **state) {
  (void)state;
  enum { ROUNDS = 100, SIZE = 8 };
  uint64_t seed = seed_new("condition_estimate");
  for (int k = 0; direct_name(k) != NULL; k++) {
    double sum = 0;
    for (int round = 0; round < ROUNDS; round++) {
      double full[SIZE * SIZE];
      for (int i = 0; i < SIZE * SIZE; i++) full[i] = seed_uniform(&seed, -1, 1);
      sct_csr *a = dense_to_csr(full, SIZE, SIZE);
      sct_solver *solver = NULL;
      const sct_solve_options options = {.dim = 0, .method = direct_name(k)};
      assert_int_equal(sct_solver_analyse(a, &options, &solver, NULL), SCT_OK);
      assert_int_equal(sct_solver_factor(solver, a, NULL), SCT_OK);
      const double ratio =
          1 / (sct_solver_report(solver)->reciprocal_condition * skeel(full, SIZE));
      assert_true(ratio > 0.02 && ratio < 1 + 1e-6);
      sum += ratio;
      sct_solver_free(&solver);
      sct_csr_free(&a);
    }
    printf("%s: mean ratio %.3f\n", direct_name(k), sum / ROUNDS);
    assert_in_range((int)(100 * sum / ROUNDS), 70, 100);
  }
}

/* Small diagonals lead pivoting with a preference for them astray; a step of refinement repairs. */
static void refinement(void **state) {
  (void)state;
  uint64_t seed = seed_new("refinement");
  problem p;
  fill_dominant(&p, &seed);
  for (int i = 0; i < N; i++) p.full[i * N + i] = 3e-3;
  p.a = dense_to_csr(p.full, N, N);
  for (int k = 0; direct_name(k) != NULL; k++) {
    double residual[2];
    for (int refined = 0; refined < 2; refined++) {
      sct_solver *solver = NULL;
      const sct_solve_options options = {
          .dim = 2, .method = direct_name(k), .backward_error = refined ? 0 : 1};
      assert_int_equal(sct_solver_analyse(p.a, &options, &solver, NULL), SCT_OK);
      assert_int_equal(sct_solver_factor(solver, p.a, NULL), SCT_OK);
      assert_int_equal(sct_solver_solve(solver, p.b, false, p.x, NULL), SCT_OK);
      residual[refined] = sct_solver_report(solver)->residual;
      assert_int_equal(sct_solver_report(solver)->iterations, refined);
      sct_solver_free(&solver);
    }
    printf("%s: residual %.1e, refined %.1e\n", direct_name(k), residual[0], residual[1]);
    assert_true(residual[1] < 1e-3 * residual[0] || residual[1] < 1e-15);
  }
  sct_csr_free(&p.a);
}

static void automatic_choice(void **state) {
  (void)state;
  const struct {
    int n, dim;
    const char *method;
  } rows[] = {{900, 2, "klu"},
              {5000, 1, "klu"},
              {1000, 2, "umfpack"},
              {399, 3, "klu"},
              {400, 3, "umfpack"}};
  for (size_t r = 0; r < sizeof rows / sizeof *rows; r++) {
    const int n = rows[r].n;
    sct_csr *a = NULL;
    sct_solver *solver = NULL;
    assert_int_equal(sct_csr_new(n, n, n, &a, NULL), SCT_OK);
    for (int i = 0; i < n; i++) {
      a->start[i + 1] = i + 1;
      a->column[i] = i;
      a->value[i] = 2;
    }
    const sct_solve_options options = {.dim = rows[r].dim, .method = r % 2 ? "direct" : "auto"};
    assert_int_equal(sct_solver_analyse(a, &options, &solver, NULL), SCT_OK);
    assert_string_equal(sct_solver_report(solver)->method, rows[r].method);
    sct_solver_free(&solver);
    sct_csr_free(&a);
  }
}

/* Seven-point stencil on a cube of `side` points: which ordering for which dimension. */
static sct_csr *cube(int side) {
  const int n = side * side * side, step[] = {1, side, side * side};
  sct_csr *a = NULL;
  int64_t k = 0;
  assert_int_equal(sct_csr_new(n, n, 7 * n, &a, NULL), SCT_OK);
  for (int i = 0; i < n; i++) {
    for (int m = -3; m <= 3; m++) {
      const int size = m == 0 ? 0 : step[abs(m) - 1], j = m < 0 ? i - size : i + size;
      const int place = m == 0 ? 0 : i / size % side, last = m < 0 ? 0 : side - 1;
      if (m != 0 && place == last) continue;
      a->column[k] = j;
      a->value[k++] = m == 0 ? 6 : -1;
    }
    a->start[i + 1] = k;
  }
  return a;
}

/* The symmetric strategy shows in "amd", the slow one would be "colamd". */
static void orderings(void **state) {
  (void)state;
  const struct {
    int side, dim;
    const char *ordering;
  } rows[] = {{15, 2, "amd"}, {15, 3, "metis"}, {14, 3, "amd"}};
  for (size_t r = 0; r < sizeof rows / sizeof *rows; r++) {
    sct_csr *a = cube(rows[r].side);
    sct_solver *solver = NULL;
    const sct_solve_options options = {.dim = rows[r].dim, .method = "umfpack"};
    assert_int_equal(sct_solver_analyse(a, &options, &solver, NULL), SCT_OK);
    assert_string_equal(sct_solver_report(solver)->ordering, rows[r].ordering);
    assert_int_equal(sct_solver_factor(solver, a, NULL), SCT_OK);
    sct_solver_free(&solver);
    sct_csr_free(&a);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(dominant),
      cmocka_unit_test(rows_permuted),
      cmocka_unit_test(rows_badly_scaled),
      cmocka_unit_test(factored_anew),
      cmocka_unit_test(failed_factors_do_not_solve),
      cmocka_unit_test(another_pattern),
      cmocka_unit_test(singular_by_value),
      cmocka_unit_test(singular_by_rounding),
      cmocka_unit_test(singular_by_structure),
      cmocka_unit_test(zero_row),
      cmocka_unit_test(one_by_one),
      cmocka_unit_test(not_finite),
      cmocka_unit_test(arguments),
      cmocka_unit_test(broken_patterns),
      cmocka_unit_test(condition_number),
      cmocka_unit_test(condition_estimate),
      cmocka_unit_test(refinement),
      cmocka_unit_test(automatic_choice),
      cmocka_unit_test(orderings),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
