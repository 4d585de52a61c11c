/* What the other tests of this folder leave of the library's entries: those that allocate, with
 * each allocation failing in its turn, and those that say they cannot fail, without any memory.
 * fault.named sees that every entry of the headers stands in one of the tests. */
#include <stdlib.h>
#include <string.h>

#include "../limited_problem.h"
#include "../verify/equation.h"
#include "scarce.h"
#include "scatter/flow_case.h"

typedef sct_status attempt(void *context, sct_error *err);

/* Until no allocation is left to fail. `repairs`: a package may know a way round. */
static void fail_each(attempt *run, void *context, bool repairs, int at_least) {
  sct_error err;
  expect_ok(run(context, &err), &err);
  for (int lasting = 0; lasting <= 1; lasting++) {
    int failures = 0;
    bool hit = true;
    for (int64_t granted = 0; hit; granted++) {
      err = (sct_error){.code = SCT_OK};
      scarce_after(granted, lasting);
      const sct_status status = run(context, &err);
      hit = scarce_end();
      if (status == SCT_OK) {
        assert_true(repairs || !hit);
        continue;
      }
      assert_true(hit);
      assert_int_equal(status, SCT_E_MEMORY);
      assert_int_equal(err.code, SCT_E_MEMORY);
      failures++;
    }
    assert_true(failures >= at_least);
  }
}

/* ---- Matrices and flows ---- */

static sct_status matrix(void *context, sct_error *err) {
  sct_csr *made = context;
  const sct_status status = sct_csr_new(3, 4, 5, &made, err);
  assert_true((made != NULL) == (status == SCT_OK));
  sct_csr_free(&made);
  return status;
}

static sct_status cavity(void *context, sct_error *err) {
  sct_flow_case made;
  (void)context;
  const sct_status status = sct_flow_cavity(8, 100, 0.3, SCT_IPS, 1, &made, err);
  sct_flow_case_clear(&made);
  return status;
}

static void objects_fail(void **state) {
  char place;
  (void)state;
  fail_each(matrix, &place, false, 4);
  fail_each(cavity, NULL, false, 2);
}

/* A flow of each scheme; fault.flow has the other ways of ips. */
static sct_status flow(void *context, sct_error *err) {
  const sct_scheme scheme = *(const sct_scheme *)context;
  sct_flow_case c;
  sct_flow *f = NULL;
  sct_status status = sct_flow_cavity(6, 50, 0, scheme, 0.1, &c, err);
  if (status == SCT_OK) status = sct_flow_build(&c.domain, &c.options, &f, err);
  if (status == SCT_OK) status = sct_flow_advance(f, 3, NULL, err);
  sct_flow_free(&f);
  sct_flow_case_clear(&c);
  return status;
}

static void flows_fail(void **state) {
  sct_scheme schemes[] = {SCT_PS, SCT_IPSN, SCT_LSMPS};
  (void)state;
  for (int k = 0; k < 3; k++) fail_each(flow, &schemes[k], true, 50);
}

/* ---- Limited convection ---- */

static void across(const double *x, double *u) {
  u[0] = 1 + x[1];
  u[1] = 0.5;
}

static double front(const double *x) {
  return x[0] > x[1];
}

static limited_problem steep(void) {
  static const posed p = {across, front, NULL, NULL, 1e-3};
  const sct_lattice lattice = {
      .dim = 2, .upper = {1, 1}, .cells = {6, 6}, .jitter = 0.3, .seed = 3};
  const sct_operator op = limited_operator(SCT_IPS);
  return limited_problem_new(&p, &lattice, &op);
}

static sct_status solve_limited(limited_problem *p, sct_error *err) {
  sct_solve_options direct = {.dim = 2, .method = "direct"};
  const sct_csr *a = p->system->matrix;
  sct_solver *solver = NULL;
  sct_limited_report report;
  sct_limited_relax(&direct);
  sct_status status = sct_solver_analyse(a, &direct, &solver, err);
  if (status == SCT_OK) status = sct_solver_factor(solver, a, err);
  if (status == SCT_OK) {
    assert_int_equal(sct_solver_report(solver)->rows, a->rows);
    status =
        sct_limited_solve(p->system, solver, &(sct_limited_options){0}, NULL, p->phi, &report, err);
  }
  sct_solver_free(&solver);
  return status;
}

/* System and solve. */
static sct_status limited(void *context, sct_error *err) {
  limited_problem *p = context;
  const sct_fields fields = {p->velocity, p->mu, p->source, NULL};
  const sct_boundary boundary = {p->condition, p->value, NULL, p->normal};
  sct_system *system = p->system;
  const sct_status status = sct_system_build(p->f.stencil, &fields, &boundary, NULL, &system, err);
  assert_true((system != NULL) == (status == SCT_OK));
  sct_system_free(&system);
  return status == SCT_OK ? solve_limited(p, err) : status;
}

static sct_status limited_march(void *context, sct_error *err) {
  limited_problem *p = context;
  const sct_march_options o = {.method = SCT_BDF2, .end = 0.02, .step = 0.01, .solve = {.dim = 2}};
  memset(p->phi, 0, (size_t)p->f.cloud.n * sizeof *p->phi);
  return sct_march(&p->system, &o, NULL, NULL, p->phi, NULL, err);
}

static void limited_fails(void **state) {
  (void)state;
  limited_problem p = steep();
  fail_each(limited, &p, true, 25);
  fail_each(limited_march, &p, true, 25);
  limited_problem_clear(&p);
}

/* ---- A march whose problem changes ---- */

enum { LEVELS = 4 };
static const double step = 0.001;

typedef struct {
  const equation *e;
  equation_data at[LEVELS];
  double *phi;
} changing;

/* The whole system anew at every time. */
static sct_status advance(void *context, double t, sct_system **system, double *phi,
                          sct_error *err) {
  const changing *c = context;
  const int level = (int)(t / step + 0.5);
  const equation_data *data = &c->at[level < LEVELS ? level : LEVELS - 1];
  sct_system *other = NULL;
  (void)phi;
  const sct_status status =
      sct_system_build(c->e->f.stencil, &data->fields, &data->boundary, NULL, &other, err);
  if (status != SCT_OK) return status;
  sct_system_free(system);
  *system = other;
  return SCT_OK;
}

static sct_status march_on(void *context, sct_error *err) {
  changing *c = context;
  const sct_march_problem problem = {
      .varies = SCT_VARIES_MATRIX | SCT_VARIES_LOAD | SCT_VARIES_DIRICHLET,
      .context = c,
      .advance = advance};
  const sct_march_options o = {
      .method = SCT_CRANK_NICOLSON, .end = 3 * step, .step = step, .solve = {.dim = 2}};
  const equation_data *data = &c->at[0];
  sct_system *system = NULL;
  sct_status status =
      sct_system_build(c->e->f.stencil, &data->fields, &data->boundary, NULL, &system, err);
  memcpy(c->phi, c->e->initial, (size_t)c->e->n * sizeof *c->phi);
  if (status == SCT_OK) status = sct_march(&system, &o, &problem, NULL, c->phi, NULL, err);
  sct_system_free(&system);
  return status;
}

static void changing_march_fails(void **state) {
  const sct_operator op = sct_operator_default(SCT_IPS, 2);
  equation e = equation_make(2, &op, false, 4);
  changing c = {.e = &e, .phi = fixture_alloc(e.n, sizeof(double))};
  (void)state;
  for (int k = 0; k < LEVELS; k++) c.at[k] = equation_at(&e, 0.1 * k);
  fail_each(march_on, &c, true, 50);
  for (int k = 0; k < LEVELS; k++) equation_data_clear(&c.at[k]);
  free(c.phi);
  equation_clear(&e);
}

/* ---- What cannot fail ---- */

/* Names, tables, views. */
static void look_up(void) {
  char room[100];
  sct_error err = {.code = SCT_OK}, other = {.code = SCT_OK};
  (void)sct_fail(&err, SCT_E_ARGUMENT, 3, "is %d", 4);
  sct_error_add_point(&err, 5);
  sct_error_merge(&other, &err);
  assert_non_null(sct_error_message(&other, room, sizeof room));
  assert_non_null(sct_status_name(SCT_OK));
  assert_non_null(sct_status_text(SCT_OK));
  assert_int_equal(sct_work_threads(NULL), 1);
  sct_work_residual(NULL, 1);
  assert_int_equal(sct_work_report(NULL, "", 0, NULL), SCT_OK);
  assert_int_equal(sct_side_find(sct_side_name(SCT_SIDE_TOP)), SCT_SIDE_TOP);
  assert_ptr_equal(sct_kernel_find(sct_kernel_at(0)->name), sct_kernel_at(0));
  assert_null(sct_kernel_at(sct_kernel_count()));
  assert_int_equal(sct_scheme_find(sct_scheme_name(SCT_IPS)), SCT_IPS);
  assert_int_equal(sct_upwind_find(sct_upwind_name((sct_upwind)1)), 1);
  assert_int_equal(sct_density_find(sct_density_name((sct_density)0)), 0);
  assert_int_equal(sct_weight_find(sct_weight_name((sct_weight)0)), 0);
  assert_int_equal(sct_march_find(sct_march_name(SCT_BDF2)), SCT_BDF2);
  assert_non_null(sct_search_method_name(SCT_SEARCH_GRID));
  assert_non_null(sct_flow_kind_name((sct_flow_kind)0));
  assert_non_null(sct_flow_walls_name((sct_flow_walls)0));
  assert_true(sct_upwind_beta(1) > 0);
  assert_false(sct_solver_iterates(&(sct_solve_options){.method = "direct"}, 10));
}

/* Clouds, stencils and matrices that are there. */
static void read_cloud(const fixture *f) {
  static double x[200];
  const sct_lattice l = {.dim = 1, .upper = {1}, .cells = {20}};
  const sct_operator op = *sct_stencil_operator(f->stencil);
  assert_int_equal(sct_cloud_check(&f->cloud, NULL), SCT_OK);
  assert_int_equal(sct_lattice_check(&l, NULL), SCT_OK);
  assert_int_equal(sct_lattice_count(&l), 21);
  assert_true(sct_lattice_spacing(&l) > 0);
  sct_lattice_points(&l, x);
  assert_int_equal(sct_search_kind(f->search), SCT_SEARCH_GRID);
  assert_int_equal(sct_operator_check(&op, NULL), SCT_OK);
  assert_int_equal(sct_stencil_cloud(f->stencil)->n, f->cloud.n);
  assert_int_equal(sct_stencil_lists(f->stencil)->n, f->cloud.n);
  assert_true(sct_stencil_spacing(f->stencil) > 0);
  assert_int_equal(sct_range_of(x, 21, 1, NULL).points, 21);
  assert_int_equal(sct_norms_of(x, x, 21, 1, NULL).points, 21);
}

static void use_system(limited_problem *p, double *room) {
  const sct_csr *a = p->system->matrix;
  const int64_t n = p->f.cloud.n;
  sct_solve_options relaxed = {.dim = 2};
  int64_t point;
  sct_system_load(p->system, p->source, p->value);
  sct_system_rhs(p->system, p->phi, room);
  assert_true(sct_csr_entries(a) > 0);
  sct_csr_multiply(a, p->phi, room);
  sct_csr_multiply_add(a, 1, p->phi, room);
  sct_csr_multiply_add_by(a, 1, p->phi, room, 1);
  sct_csr_multiply_transposed_add(a, 1, p->phi, room);
  sct_csr_residual(a, p->phi, room, room + n, room + 2 * n);
  sct_csr_residual_transposed(a, p->phi, room, room + n, room + 2 * n);
  sct_limited_correction(p->system, p->phi, NULL, room, room + 2 * n);
  assert_true(sct_limited_reach(p->system, 0) >= 0);
  sct_limited_relax(&relaxed);
  assert_true(sct_march_stable_step(p->system, &point) > 0);
}

static void read_flow(const sct_flow *f) {
  const sct_flow_sample *samples;
  static double line[64], value[64];
  assert_false(sct_flow_is_done(f));
  assert_true(sct_flow_particles(f).n > 0);
  assert_int_equal(sct_flow_snapshots(f), 1);
  assert_true(sct_flow_snapshot(f, 0).n > 0);
  assert_true(sct_flow_wall_points(f).n > 0);
  sct_flow_mesh(f, true, NULL, NULL, NULL, NULL);
  assert_in_range(sct_flow_section_most(f, 0), 1, 64);
  assert_true(sct_flow_section(f, true, 0, 0.5, line, value) > 0);
  assert_true(sct_flow_find_vortex(f, true).x > 0);
  (void)sct_flow_reattachment(f, true, 0, 0);
  (void)sct_flow_history(f, &samples);
  assert_int_equal(sct_flow_reports(f).cells, 64);
}

static sct_flow *begun_flow(sct_flow_case *c) {
  static const double first[] = {1e-3};
  sct_flow *f = NULL;
  expect_ok(sct_flow_cavity(8, 50, 0, SCT_IPS, 1, c, NULL), NULL);
  c->options.save = first;
  c->options.saves = 1;
  expect_ok(sct_flow_build(&c->domain, &c->options, &f, NULL), NULL);
  expect_ok(sct_flow_advance(f, 2, NULL, NULL), NULL);
  return f;
}

static void needs_no_memory(void **state) {
  sct_flow_case c;
  double edge[5];
  (void)state;
  limited_problem p = steep();
  double *room = fixture_alloc(4 * p.f.cloud.n, sizeof *room);
  sct_flow *f = begun_flow(&c);
  scarce_after(0, true);
  look_up();
  read_cloud(&p.f);
  use_system(&p, room);
  read_flow(f);
  sct_flow_lines(0, 1, 4, 0.5, edge);
  assert_true(sct_flow_default(SCT_IPS, 1, 1).end > 0);
  assert_false(scarce_end());
  sct_flow_free(&f);
  sct_flow_case_clear(&c);
  free(room);
  limited_problem_clear(&p);
}

/* Preparing never fails; who then wants the iterative solver is told whether it is there. */
static void preparing_bears_it(void **state) {
  (void)state;
  sct_error err = {.code = SCT_OK};
  scarce_after(0, true);
  sct_solver_prepare();
  (void)scarce_end();
  const sct_status status = sct_solver_load_iterative(&err);
  assert_int_equal(status, err.code);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(objects_fail),         cmocka_unit_test(limited_fails),
      cmocka_unit_test(changing_march_fails), cmocka_unit_test(flows_fail),
      cmocka_unit_test(needs_no_memory),      cmocka_unit_test(preparing_bears_it),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
