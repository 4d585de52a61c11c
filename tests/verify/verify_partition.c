/* Rows that parts make are, bit for bit, those of the whole: every scheme and dimension, with
 * upwinding and conditions, on jittered and on fully random clouds, whose rows look far. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "manufactured.h"

typedef struct {
  fixture f;
  manufactured m;
  sct_operator op;
  sct_fields fields;
  sct_boundary boundary;
} problem;

static void take_data(problem *p) {
  p->m = manufactured_new(&p->f, 0);
  p->fields = manufactured_fields(&p->m);
  p->boundary = manufactured_boundary(&p->m);
}

static problem jittered(int dim, int64_t cells, sct_operator op, double jitter) {
  problem p = {.op = op};
  p.f = fixture_unit(dim, cells, jitter, 21, &op);
  take_data(&p);
  manufactured_side(&p.m, SCT_SIDE_RIGHT, SCT_NEUMANN);
  if (dim > 1) manufactured_side(&p.m, SCT_SIDE_TOP, SCT_ROBIN);
  return p;
}

/* Points anywhere; those near the rim have given values. */
static problem scattered(int dim, int64_t n, sct_operator op) {
  problem p = {.op = op};
  uint64_t seed = 4;
  double *x = fixture_alloc(n * dim, sizeof *x), cells = 1;
  for (int64_t k = 0; k < n * dim; k++) x[k] = fixture_random(&seed);
  while (dim == 2 ? cells * cells < (double)n : cells * cells * cells < (double)n) cells++;
  p.f = fixture_points(dim, n, x, 1 / cells, &op);
  for (int64_t i = 0; i < n; i++) {
    for (int a = 0; a < dim; a++) {
      const double at = x[i * dim + a];
      p.f.inside[i] &= at > 0.03 && at < 0.97;
    }
  }
  take_data(&p);
  free(x);
  return p;
}

static void problem_free(problem *p) {
  manufactured_free(&p->m);
  fixture_clear(&p->f);
}

static double entry(const sct_csr *a, int64_t row, int64_t column) {
  for (int64_t k = a->start[row]; k < a->start[row + 1]; k++) {
    if (a->column[k] == column) return a->value[k];
  }
  fail_msg("row %lld has no column %lld", (long long)row, (long long)column);
  return 0;
}

/* An entry of the part in the whole: of a column that is unknown there, or given. */
static void expect_entry(const sct_system *whole, int32_t point, int32_t column, double value) {
  const int32_t row = whole->row_of[point], unknown = whole->row_of[column];
  const double there =
      unknown >= 0 ? entry(whole->matrix, row, unknown) : entry(whole->coupling, row, column);
  assert_memory_equal(&there, &value, sizeof value);
}

/* All rows of a part; returns how many. */
static int64_t expect_rows(const sct_system *whole, const sct_part_system *s) {
  const sct_system *own = s->system;
  for (int64_t row = 0; own != NULL && row < own->unknowns; row++) {
    const int32_t point = s->part->point[own->point_of[row]], there = whole->row_of[point];
    int64_t entries = 0;
    for (int64_t k = own->matrix->start[row]; k < own->matrix->start[row + 1]; k++, entries++) {
      const int32_t column = s->part->point[own->point_of[own->matrix->column[k]]];
      expect_entry(whole, point, column, own->matrix->value[k]);
    }
    for (int64_t k = own->coupling->start[row]; k < own->coupling->start[row + 1]; k++, entries++) {
      const int32_t column = s->part->point[own->coupling->column[k]];
      expect_entry(whole, point, column, own->coupling->value[k]);
    }
    assert_int_equal(entries, whole->matrix->start[there + 1] - whole->matrix->start[there] +
                                  whole->coupling->start[there + 1] -
                                  whole->coupling->start[there]);
    assert_memory_equal(&own->load[row], &whole->load[there], sizeof(double));
    assert_int_equal(own->is_equation[row], whole->is_equation[there]);
  }
  return own != NULL ? own->unknowns : 0;
}

/* Numbers run along the curve, part by part. */
static void expect_numbers(const sct_part_system *s, int64_t first, int64_t own) {
  assert_int_equal(s->first, first);
  int64_t found = 0;
  for (int64_t m = 0; m < s->part->n; m++) {
    const bool mine = s->number[m] >= first && s->number[m] < first + own;
    assert_int_equal(mine, s->part->is_own[m] && s->number[m] >= 0);
    found += mine;
  }
  assert_int_equal(found, own);
}

static void compare(problem *p, int parts, const char *name) {
  sct_system *whole;
  sct_partition *partition;
  sct_error err;
  int64_t unknowns = 0, halo = 0, widened = 0, loose = 0;
  int rounds = 0;
  expect_ok(sct_system_build(p->f.stencil, &p->fields, &p->boundary, NULL, &whole, &err), &err);
  expect_ok(sct_partition_build(&p->f.cloud, parts, false, &partition, &err), &err);
  const sct_part_problem all = {&p->f.cloud,        partition,  p->f.spacing, &p->op,
                                FIXTURE_NEIGHBOURS, &p->fields, &p->boundary};
  for (int k = 0; k < parts; k++) {
    sct_part_system *s;
    expect_ok(sct_part_assemble(&all, k, NULL, &s, &err), &err);
    const int64_t own = expect_rows(whole, s);
    expect_numbers(s, unknowns, own);
    assert_int_equal(s->unknowns, whole->unknowns);
    unknowns += own;
    halo += s->part->n - s->part->own;
    rounds = s->rounds > rounds ? s->rounds : rounds;
    widened += s->system != NULL ? s->system->widened : 0;
    loose += s->system != NULL ? s->system->loose : 0;
    sct_part_system_free(&s);
  }
  print_message("%-28s %d-D %5lld points in %2d parts: halo %5lld, %4lld widened, %d rounds\n",
                name, p->f.cloud.dim, (long long)p->f.cloud.n, parts, (long long)halo,
                (long long)widened, rounds);
  assert_int_equal(unknowns, whole->unknowns);
  assert_int_equal(widened, whole->widened);
  assert_int_equal(loose, whole->loose);
  sct_partition_free(&partition);
  sct_system_free(&whole);
}

static void every_scheme(void **state) {
  (void)state;
  static const int64_t cells[] = {0, 300, 40, 14};
  static const int parts[] = {1, 2, 4, 13};
  char name[64];
  for (int dim = 1; dim <= 3; dim++) {
    for (int k = 0; k < SCT_SCHEME_COUNT; k++) {
      for (int degree = 2; degree <= (k == SCT_LSMPS ? 4 : 2); degree++) {
        sct_operator op = sct_operator_default((sct_scheme)k, degree);
        if (degree == 2 && dim > 1) op.upwind = SCT_UPWIND_COSINE;
        problem p = jittered(dim, cells[dim], op, 0.6);
        snprintf(name, sizeof name, "%s %d", sct_scheme_name((sct_scheme)k), degree);
        compare(&p, parts[(k + degree) % 4], name);
        problem_free(&p);
      }
    }
  }
}

static void clouds_without_order(void **state) {
  (void)state;
  for (int dim = 2; dim <= 3; dim++) {
    for (int k = 0; k < SCT_SCHEME_COUNT; k++) {
      problem p = scattered(dim, dim == 2 ? 3000 : 5000, sct_operator_default((sct_scheme)k, 2));
      compare(&p, 3, sct_scheme_name((sct_scheme)k));
      compare(&p, 16, sct_scheme_name((sct_scheme)k));
      problem_free(&p);
    }
  }
}

/* Diffusion in one half only: the other half must know of it. */
static void diffusion_elsewhere(void **state) {
  (void)state;
  problem p = jittered(2, 30, sct_operator_default(SCT_LSMPS, 2), 0.3);
  for (int64_t i = 0; i < p.f.cloud.n; i++) {
    if (p.f.x[2 * i + 1] > 0.2) p.m.diffusivity[i] = 0;
  }
  compare(&p, 4, "no diffusion above");
  problem_free(&p);
}

/* A point on its own fails with the same words, and its number in the whole. */
static void failures_are_the_same(void **state) {
  (void)state;
  problem p = jittered(2, 20, sct_operator_default(SCT_PS, 2), 0.3);
  sct_system *whole;
  sct_partition *partition;
  sct_part_system *s;
  sct_error of_whole, of_part;
  int64_t i = 5 * 21 + 7; /* inside */
  p.f.x[2 * i] = 50;
  sct_search *search;
  sct_stencil *stencil;
  expect_ok(sct_search_build(&p.f.cloud, 0, SCT_SEARCH_AUTO, NULL, &search, &of_whole), &of_whole);
  expect_ok(sct_stencil_build(&p.f.cloud, search, p.f.spacing, &p.op, FIXTURE_NEIGHBOURS, NULL,
                              &stencil, &of_whole),
            &of_whole);
  assert_int_equal(sct_system_build(stencil, &p.fields, &p.boundary, NULL, &whole, &of_whole),
                   SCT_E_DEFICIENT);
  expect_ok(sct_partition_build(&p.f.cloud, 3, false, &partition, &of_part), &of_part);
  const sct_part_problem all = {&p.f.cloud,         partition, p.f.spacing, &p.op,
                                FIXTURE_NEIGHBOURS, &p.fields, &p.boundary};
  int failed = 0;
  for (int k = 0; k < 3; k++) {
    if (sct_part_assemble(&all, k, NULL, &s, &of_part) == SCT_OK) {
      sct_part_system_free(&s);
      continue;
    }
    failed++;
    assert_null(s);
    assert_int_equal(of_part.code, of_whole.code);
    assert_int_equal(of_part.point, i);
    assert_int_equal(of_part.point, of_whole.point);
    assert_string_equal(of_part.text, of_whole.text);
  }
  assert_int_equal(failed, 1);
  sct_partition_free(&partition);
  sct_stencil_free(&stencil);
  sct_search_free(&search);
  problem_free(&p);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_scheme),
      cmocka_unit_test(clouds_without_order),
      cmocka_unit_test(diffusion_elsewhere),
      cmocka_unit_test(failures_are_the_same),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
