/* Stencils, their rows, systems and diagnoses with the n-th allocation failing, for every n:
 * SCT_E_MEMORY, no output, no leak (with -DSCATTERD_SANITIZE=ON), and what failed works when it is
 * called again. */
#include "fixture.h"

#include <math.h>

#include "fail_each.h"
#include "scarce.h"

/* A square lattice without the points nearer than HOLE to the middle one: more than one block of
 * work, and a row in the middle that outgrows the room it begins in. */
enum { SIDE = 21, MIDDLE = SIDE / 2, N = SIDE * SIDE };
static const double HOLE = 5.2;

static fixture all;
static int threads;

static const sct_work *work(void) {
  static sct_work w;
  w.threads = threads;
  return &w;
}

static sct_status build(sct_error *err) {
  const sct_operator op = *sct_stencil_operator(all.stencil);
  sct_stencil *stencil = (sct_stencil *)&all;
  const sct_status status = sct_stencil_build(&all.cloud, all.search, all.spacing, &op,
                                              FIXTURE_NEIGHBOURS, work(), &stencil, err);
  assert_true((stencil != NULL) == (status == SCT_OK));
  sct_stencil_free(&stencil);
  return status;
}

/* The row in the middle, in a room that has to grow for it. */
static sct_status row(sct_error *err) {
  sct_room *room = (sct_room *)&all;
  sct_row r;
  const sct_row_request request = {.want = SCT_ROW_LAPLACIAN | SCT_ROW_GRADIENT | SCT_ROW_SOLVE};
  sct_status status = sct_room_new(all.stencil, &room, err);
  assert_true((room != NULL) == (status == SCT_OK));
  if (status == SCT_OK) {
    status = sct_stencil_row(all.stencil, all.cloud.n - 1, &request, room, &r, err);
    if (status == SCT_E_MEMORY) {
      scarce_end(); /* as good as new */
      expect_ok(sct_stencil_row(all.stencil, all.cloud.n - 1, &request, room, &r, NULL), NULL);
    }
  }
  sct_room_free(&room);
  return status;
}

static sct_status apply(sct_error *err) {
  static double field[N], smoothed[N], gradient[2 * N], laplacian[N];
  return sct_stencil_apply(all.stencil, field, work(), smoothed, gradient, laplacian, err);
}

static sct_status apply_flagged(sct_error *err) {
  static double field[N], laplacian[N];
  static uint8_t flags[N];
  return sct_stencil_apply_flagged(all.stencil, field, work(), NULL, NULL, laplacian, flags, err);
}

static sct_status diagnose(sct_error *err) {
  static int32_t neighbours[N];
  static double density[N], velocity[2 * N], tensor[3 * N], condition[N];
  const sct_diagnosis to = {neighbours, density, velocity, tensor, condition};
  return sct_diagnose(all.stencil, work(), &to, err);
}

/* Convection, diffusion and every condition but Dirichlet: with `reaction` 0 it is singular. */
static sct_status assemble(sct_condition condition, sct_system **system, sct_error *err) {
  static double one[2 * N], normal[2 * N];
  static uint8_t conditions[N];
  for (int k = 0; k < 2 * N; k++) one[k] = normal[k] = 1;
  for (int64_t i = 0; i < all.cloud.n; i++) {
    conditions[i] = all.x[2 * i] > 0 ? SCT_INTERIOR : (uint8_t)condition;
  }
  const sct_fields fields = {.velocity = one, .diffusivity = one, .source = one};
  const sct_boundary boundary = {conditions, one, one, normal};
  return sct_system_build(all.stencil, &fields, &boundary, work(), system, err);
}

static sct_status system_of(sct_condition condition, sct_error *err) {
  sct_system *system = (sct_system *)&all;
  const sct_status status = assemble(condition, &system, err);
  assert_true((system != NULL) == (status == SCT_OK));
  sct_system_free(&system);
  return status;
}

static sct_status dirichlet(sct_error *err) {
  return system_of(SCT_DIRICHLET, err);
}

static sct_status robin(sct_error *err) {
  return system_of(SCT_ROBIN, err);
}

/* The lattice, displaced a little, for rows of this scheme; the middle is the last point. */
static void with_scheme(int scheme) {
  const sct_operator op = sct_operator_default((sct_scheme)scheme, 2);
  static double x[2 * N];
  int64_t n = 0;
  uint64_t random = 4;
  fixture_clear(&all);
  for (int k = 0; k < N; k++) {
    const int a = k % SIDE, b = k / SIDE;
    if (hypot(a - MIDDLE, b - MIDDLE) < HOLE) continue;
    x[2 * n] = a + (a > 0 ? 0.1 * fixture_random(&random) : 0);
    x[2 * n++ + 1] = b;
  }
  x[2 * n] = x[2 * n + 1] = MIDDLE;
  all = fixture_points(2, n + 1, x, 1, &op);
}

static void each_scheme(attempt *run, int at_least) {
  for (int scheme = 0; scheme < SCT_SCHEME_COUNT; scheme++) {
    for (threads = 1; threads <= (scheme == SCT_LSMPS ? 2 : 1); threads++) {
      with_scheme(scheme);
      fail_each(run, at_least);
    }
  }
}

static void stencils_fail(void **state) {
  (void)state;
  each_scheme(build, 3);
}

static void rows_fail(void **state) {
  (void)state;
  each_scheme(row, 4);
}

static void applications_fail(void **state) {
  (void)state;
  each_scheme(apply, 3);
  each_scheme(apply_flagged, 3);
}

static void diagnoses_fail(void **state) {
  (void)state;
  each_scheme(diagnose, 3);
}

static void systems_fail(void **state) {
  (void)state;
  each_scheme(dirichlet, 12);
  each_scheme(robin, 12);
}

/* Without memory no cause is found, and nothing is said. */
static void explanations_fail(void **state) {
  (void)state;
  sct_system *system = NULL;
  sct_error err;
  int64_t granted = 0;
  with_scheme(SCT_IPS);
  expect_ok(assemble(SCT_NEUMANN, &system, &err), &err);
  for (bool failed = true; failed; granted++) {
    err = (sct_error){.code = SCT_OK};
    scarce_after(granted, false);
    const bool found = sct_system_explain(system, &err);
    failed = scarce_end();
    assert_int_equal(found, !failed);
    assert_int_equal(err.code, failed ? SCT_OK : SCT_E_SINGULAR);
  }
  assert_true(granted > 4);
  sct_system_free(&system);
}

static int clear(void **state) {
  (void)state;
  fixture_clear(&all);
  return 0;
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(stencils_fail),     cmocka_unit_test(rows_fail),
      cmocka_unit_test(applications_fail), cmocka_unit_test(diagnoses_fail),
      cmocka_unit_test(systems_fail),      cmocka_unit_test(explanations_fail),
  };
  return cmocka_run_group_tests(tests, NULL, clear);
}
