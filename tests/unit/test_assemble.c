/* unit.assemble: shape of the system, what is refused, why a system is singular. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fixture.h"

typedef struct {
  fixture f;
  double *mu, *value, *normal, *coefficient, *reaction;
  uint8_t *condition;
} problem;

static problem problem_on(fixture f) {
  problem p = {.f = f};
  const int64_t n = f.cloud.n;
  p.mu = fixture_alloc(n, sizeof *p.mu);
  p.value = fixture_alloc(n, sizeof *p.value);
  p.coefficient = fixture_alloc(n, sizeof *p.coefficient);
  p.reaction = fixture_alloc(n, sizeof *p.reaction);
  p.normal = fixture_alloc(n * f.cloud.dim, sizeof *p.normal);
  p.condition = fixture_alloc(n, 1);
  for (int64_t i = 0; i < n; i++) p.mu[i] = 1;
  return p;
}

static void problem_clear(problem *p) {
  free(p->mu);
  free(p->value);
  free(p->coefficient);
  free(p->reaction);
  free(p->normal);
  free(p->condition);
  fixture_clear(&p->f);
}

static sct_status build(const problem *p, sct_system **system, sct_error *err) {
  const sct_fields fields = {.diffusivity = p->mu, .reaction = p->reaction};
  const sct_boundary boundary = {p->condition, p->value, p->coefficient, p->normal};
  return sct_system_build(p->f.stencil, &fields, &boundary, NULL, system, err);
}

/* Unit square whose boundary carries `condition` with its outward normals. */
static problem square(sct_condition condition) {
  const sct_operator op = sct_operator_default(SCT_IPS, 2);
  problem p = problem_on(fixture_unit(2, 8, 0.2, 5, &op));
  sct_group group;
  sct_error err;
  expect_ok(sct_lattice_group(&p.f.lattice, SCT_SIDE_BOUNDARY, &group, &err), &err);
  for (int64_t k = 0; k < group.n; k++) {
    p.condition[group.index[k]] = (uint8_t)condition;
    memcpy(p.normal + 2 * group.index[k], group.normal + 2 * k, 2 * sizeof(double));
  }
  sct_group_clear(&group);
  return p;
}

static void dirichlet_points_are_eliminated(void **state) {
  (void)state;
  problem p = square(SCT_DIRICHLET);
  sct_system *s = NULL;
  sct_error err;
  expect_ok(build(&p, &s, &err), &err);
  assert_int_equal(s->unknowns, 49);
  assert_int_equal(s->matrix->rows, 49);
  assert_int_equal(s->coupling->columns, 81);
  for (int64_t row = 0; row < s->unknowns; row++) {
    double sum = 0;
    assert_int_equal(s->row_of[s->point_of[row]], row);
    for (int64_t e = s->matrix->start[row]; e < s->matrix->start[row + 1]; e++) {
      sum += s->matrix->value[e];
      if (e > s->matrix->start[row]) assert_true(s->matrix->column[e] > s->matrix->column[e - 1]);
    }
    for (int64_t e = s->coupling->start[row]; e < s->coupling->start[row + 1]; e++) {
      sum += s->coupling->value[e];
      assert_int_equal(p.condition[s->coupling->column[e]], SCT_DIRICHLET);
    }
    assert_true(fabs(sum) < 1e-10); /* constants are annihilated */
  }
  assert_false(sct_system_explain(s, &err));
  sct_system_free(&s);
  problem_clear(&p);
}

static void without_a_value_only_up_to_a_constant(void **state) {
  (void)state;
  problem p = square(SCT_NEUMANN);
  sct_system *s = NULL;
  sct_error err;
  expect_ok(build(&p, &s, &err), &err);
  assert_true(sct_system_explain(s, &err));
  assert_int_equal(err.code, SCT_E_SINGULAR);
  assert_non_null(strstr(err.text, "up to a constant"));
  sct_system_free(&s);
  for (int64_t i = 0; i < p.f.cloud.n; i++) p.reaction[i] = 1e-3;
  expect_ok(build(&p, &s, &err), &err);
  assert_false(sct_system_explain(s, &err));
  sct_system_free(&s);
  problem_clear(&p);
  p = square(SCT_ROBIN);
  for (int64_t i = 0; i < p.f.cloud.n; i++) p.coefficient[i] = 2;
  expect_ok(build(&p, &s, &err), &err);
  assert_false(sct_system_explain(s, &err));
  sct_system_free(&s);
  problem_clear(&p);
}

/* Without diffusion, velocity and reaction a point has no equation. */
static void points_without_an_equation_are_named(void **state) {
  (void)state;
  problem p = square(SCT_DIRICHLET);
  sct_system *s = NULL;
  sct_error err;
  expect_ok(build(&p, &s, &err), &err);
  for (int64_t e = s->matrix->start[5]; e < s->matrix->start[7]; e++) s->matrix->value[e] = 0;
  for (int64_t e = s->coupling->start[5]; e < s->coupling->start[7]; e++) s->coupling->value[e] = 0;
  assert_true(sct_system_explain(s, &err));
  assert_int_equal(err.code, SCT_E_SINGULAR);
  assert_int_equal(err.count, 2);
  assert_int_equal(err.point, s->point_of[5]);
  assert_int_equal(err.points[1], s->point_of[6]);
  assert_non_null(strstr(err.text, "no equation"));
  sct_system_free(&s);
  problem_clear(&p);
}

/* The weights of the neighbours of a point may cancel, and leave Dirichlet values alone. */
static void points_without_an_unknown_are_named(void **state) {
  (void)state;
  problem p = square(SCT_DIRICHLET);
  sct_system *s = NULL;
  sct_error err;
  expect_ok(build(&p, &s, &err), &err);
  for (int64_t e = s->matrix->start[0]; e < s->matrix->start[1]; e++) s->matrix->value[e] = 0;
  assert_true(s->coupling->start[1] > s->coupling->start[0]);
  assert_true(sct_system_explain(s, &err));
  assert_int_equal(err.code, SCT_E_SINGULAR);
  assert_int_equal(err.count, 1);
  assert_int_equal(err.point, s->point_of[0]);
  assert_non_null(strstr(err.text, "without an unknown"));
  sct_system_free(&s);
  problem_clear(&p);
}

/* Two squares far apart, only the first with a Dirichlet point. */
static void an_isolated_group_is_named(void **state) {
  (void)state;
  double x[2 * 72];
  sct_error err;
  sct_system *s = NULL;
  const sct_operator op = sct_operator_default(SCT_PS, 2);
  for (int k = 0; k < 72; k++) {
    x[2 * k] = k % 6 + (k < 36 ? 0 : 50);
    x[2 * k + 1] = k / 6 % 6;
  }
  problem p = problem_on(fixture_points(2, 72, x, 1, &op));
  p.condition[7] = SCT_DIRICHLET;
  expect_ok(build(&p, &s, &err), &err);
  assert_true(sct_system_explain(s, &err));
  assert_int_equal(err.count, 36);
  assert_int_equal(err.points[0], 36);
  assert_non_null(strstr(err.text, "isolated"));
  sct_system_free(&s);
  problem_clear(&p);
}

static void what_cannot_be_assembled_is_refused(void **state) {
  (void)state;
  sct_system *s = NULL;
  sct_error err;
  problem p = square(SCT_DIRICHLET);
  p.mu[17] = -1;
  assert_int_equal(build(&p, &s, &err), SCT_E_ARGUMENT);
  assert_int_equal(err.point, 17);
  assert_null(s);
  p.mu[17] = NAN;
  assert_int_equal(build(&p, &s, &err), SCT_E_ARGUMENT);
  p.mu[17] = 1;
  memset(p.condition, SCT_DIRICHLET, 81);
  assert_int_equal(build(&p, &s, &err), SCT_E_ARGUMENT);
  memset(p.condition, SCT_INTERIOR, 81);
  p.condition[3] = SCT_NEUMANN;
  memset(p.normal, 0, 81 * 2 * sizeof *p.normal);
  assert_int_equal(build(&p, &s, &err), SCT_E_ARGUMENT);
  assert_int_equal(err.point, 3);
  p.normal[6] = 1;
  p.normal[7] = NAN;
  assert_int_equal(build(&p, &s, &err), SCT_E_ARGUMENT);
  p.normal[7] = INFINITY;
  assert_int_equal(build(&p, &s, &err), SCT_E_ARGUMENT);
  assert_null(s);
  problem_clear(&p);
}

/* A normal is a direction: from the smallest double to the largest, its length changes nothing. */
static void normals_may_have_any_length(void **state) {
  (void)state;
  static const int powers[] = {-1074, -540, 540, 1023};
  sct_error err;
  for (size_t k = 0; k < sizeof powers / sizeof *powers; k++) {
    problem p = square(SCT_ROBIN), q = square(SCT_ROBIN);
    sct_system *s = NULL, *t = NULL;
    for (int64_t e = 0; e < 2 * p.f.cloud.n; e++) {
      p.normal[e] = (p.normal[e] > 0) - (p.normal[e] < 0);
      q.normal[e] = ldexp(p.normal[e], powers[k]);
    }
    expect_ok(build(&p, &s, &err), &err);
    expect_ok(build(&q, &t, &err), &err);
    const size_t entries = (size_t)s->matrix->start[s->matrix->rows];
    assert_memory_equal(s->matrix->value, t->matrix->value, entries * sizeof(double));
    sct_system_free(&s);
    sct_system_free(&t);
    problem_clear(&p);
    problem_clear(&q);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(dirichlet_points_are_eliminated),
      cmocka_unit_test(without_a_value_only_up_to_a_constant),
      cmocka_unit_test(points_without_an_equation_are_named),
      cmocka_unit_test(points_without_an_unknown_are_named),
      cmocka_unit_test(an_isolated_group_is_named),
      cmocka_unit_test(what_cannot_be_assembled_is_refused),
      cmocka_unit_test(normals_may_have_any_length),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
