/* verify.heat: marches of assembled systems. The diffusion problem of [H16] in two dimensions
 * against an independent implementation; no march of a sound problem is taken for unstable, and
 * what is not sound is seen. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fixture.h"

#include "near.h" /* after cmocka, in fixture.h */

static const double pi = 3.14159265358979323846;

typedef struct {
  double *velocity, *diffusivity, *value, *coefficient, *normal, *phi;
  uint8_t *condition;
  sct_system *system;
} problem;

static problem problem_new(int64_t n, int dim) {
  return (problem){.velocity = fixture_alloc(n * dim, sizeof(double)),
                   .diffusivity = fixture_alloc(n, sizeof(double)),
                   .value = fixture_alloc(n, sizeof(double)),
                   .coefficient = fixture_alloc(n, sizeof(double)),
                   .normal = fixture_alloc(n * dim, sizeof(double)),
                   .phi = fixture_alloc(n, sizeof(double)),
                   .condition = fixture_alloc(n, 1)};
}

static void problem_free(problem *p) {
  double *const arrays[] = {p->velocity,    p->diffusivity, p->value,
                            p->coefficient, p->normal,      p->phi};
  for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++) free(arrays[k]);
  free(p->condition);
  sct_system_free(&p->system);
}

static void assemble(const fixture *f, problem *p) {
  const sct_fields fields = {.velocity = p->velocity, .diffusivity = p->diffusivity};
  const sct_boundary boundary = {p->condition, p->value, p->coefficient, p->normal};
  sct_error err;
  expect_ok(sct_system_build(f->stencil, &fields, &boundary, NULL, &p->system, &err), &err);
}

/* -- diffusion-2d of [H16] ----------------------------------------------------------------- */

static double exact(double x, double y, double t) {
  return exp(-8 * pi * pi * t) * sin(2 * pi * x) * sin(2 * pi * y) + 4 * x * (x - 1) -
         4 * y * (y - 1) + (x - 0.5) * (y - 0.5);
}

/* Root mean square errors at t = 0.005 and 0.01. */
typedef struct {
  const fixture *f;
  double error[2];
  int saves;
} errors;

static sct_status note_error(void *context, double t, const double *phi, sct_error *err) {
  errors *e = context;
  double sum = 0;
  int64_t count = 0;
  (void)err;
  for (int64_t i = 0; i < e->f->cloud.n; i++) {
    const double *x = e->f->x + 2 * i;
    if (!e->f->inside[i]) continue;
    sum += pow(phi[i] - exact(x[0], x[1], t), 2);
    count++;
  }
  if (e->saves < 2) e->error[e->saves++] = sqrt(sum / (double)count);
  return SCT_OK;
}

static void diffusion_2d(const sct_operator *op, const sct_march_options *options, uint64_t seed,
                         double error[2]) {
  fixture f = fixture_unit(2, 16, 0.3, seed, op);
  problem p = problem_new(f.cloud.n, 2);
  sct_error err;
  errors e = {.f = &f};
  for (int64_t i = 0; i < f.cloud.n; i++) {
    p.diffusivity[i] = 1;
    p.condition[i] = f.inside[i] ? SCT_INTERIOR : SCT_DIRICHLET;
    p.phi[i] = p.value[i] = exact(f.x[2 * i], f.x[2 * i + 1], 0);
  }
  assemble(&f, &p);
  const sct_march_problem march = {.context = &e, .save = note_error};
  expect_ok(sct_march(&p.system, options, &march, NULL, p.phi, NULL, &err), &err);
  memcpy(error, e.error, sizeof e.error);
  problem_free(&p);
  fixture_clear(&f);
}

static const double times[] = {0.005, 0.01};

/* Mean and deviation of one run, from 10 to 20 clouds of another generator. */
static void errors_of_h16(void **state) {
  (void)state;
  const struct {
    const char *scheme;
    double radius, mean[2], deviation[2];
  } rows[] = {{"ps", 2.0, {3.59e-2, 3.33e-2}, {2.3e-3, 2.4e-3}},
              {"ips", 2.0, {3.66e-3, 3.86e-3}, {3.7e-4, 5.8e-4}},
              {"ipsn", 2.0, {3.16e-3, 3.11e-3}, {2.2e-4, 3.3e-4}},
              {"lsmps", 2.1, {1.69e-3, 2.15e-3}, {1.4e-4, 2.0e-4}}};
  const sct_march_options options = {.method = SCT_FORWARD_EULER,
                                     .end = 0.01,
                                     .diffusion_number = 1,
                                     .save = times,
                                     .saves = 2,
                                     .solve = {.dim = 2}};
  enum { SEEDS = 10 };
  for (size_t r = 0; r < sizeof rows / sizeof *rows; r++) {
    sct_operator op = sct_operator_default(sct_scheme_find(rows[r].scheme), 2);
    double mean[2] = {0};
    op.radius = rows[r].radius;
    for (uint64_t seed = 0; seed < SEEDS; seed++) {
      double error[2];
      diffusion_2d(&op, &options, seed, error);
      for (int k = 0; k < 2; k++) mean[k] += error[k] / SEEDS;
    }
    for (int k = 0; k < 2; k++) {
      print_message("%s t = %g: %.3e, expected %.3e +- %.1e\n", rows[r].scheme, times[k], mean[k],
                    rows[r].mean[k], rows[r].deviation[k]);
      assert_near(mean[k], rows[r].mean[k], 2 * rows[r].deviation[k]);
    }
  }
}

/* What is left is the error of space, the same for every scheme with small steps. */
static void time_schemes_agree(void **state) {
  (void)state;
  const sct_operator op = sct_operator_default(SCT_LSMPS, 2);
  double error[SCT_MARCH_COUNT][2];
  for (int method = 0; method < SCT_MARCH_COUNT; method++) {
    const sct_march_options options = {.method = method,
                                       .end = 0.01,
                                       .step = method == SCT_FORWARD_EULER ? 1e-6 : 1e-5,
                                       .save = times,
                                       .saves = 2,
                                       .solve = {.dim = 2}};
    diffusion_2d(&op, &options, 3, error[method]);
    for (int k = 0; k < 2; k++) assert_near(error[method][k], error[0][k], 0.1 * error[0][k]);
  }
}

/* -- sound and unsound --------------------------------------------------------------------- */

/* Rotation and diffusion from phi = 1; all cold walls, or walls of all kinds. */
static problem rotation(const fixture *f, double diffusivity, bool mixed) {
  const int dim = f->cloud.dim;
  problem p = problem_new(f->cloud.n, dim);
  sct_group group;
  sct_error err;
  for (int64_t i = 0; i < f->cloud.n; i++) {
    const double *x = f->x + i * dim;
    p.velocity[i * dim] = dim > 1 ? x[1] - 0.5 : 1;
    if (dim > 1) p.velocity[i * dim + 1] = 0.5 - x[0];
    p.diffusivity[i] = diffusivity;
    p.coefficient[i] = 2;
    p.condition[i] = f->inside[i] ? SCT_INTERIOR : mixed ? SCT_NEUMANN : SCT_DIRICHLET;
    p.phi[i] = f->inside[i] || mixed ? 1 : 0;
  }
  expect_ok(sct_lattice_group(&f->lattice, SCT_SIDE_BOUNDARY, &group, &err), &err);
  for (int64_t k = 0; k < group.n; k++) {
    memcpy(p.normal + group.index[k] * dim, group.normal + (group.normals == 1 ? 0 : k * dim),
           (size_t)dim * sizeof *p.normal);
  }
  sct_group_clear(&group);
  for (int side = SCT_SIDE_LEFT; mixed && side <= SCT_SIDE_RIGHT; side++) {
    expect_ok(sct_lattice_group(&f->lattice, side, &group, &err), &err);
    for (int64_t k = 0; k < group.n; k++) {
      const int64_t i = group.index[k];
      p.condition[i] = side == SCT_SIDE_LEFT ? SCT_DIRICHLET : SCT_ROBIN;
      if (side == SCT_SIDE_LEFT) p.phi[i] = 0;
    }
    sct_group_clear(&group);
  }
  assemble(f, &p);
  return p;
}

/* 300 steps of C_D = number from phi = 1; max |phi| in *largest. */
static sct_status march_rotation(const fixture *f, double diffusivity, bool mixed,
                                 sct_march_method method, double number, double *largest,
                                 sct_error *err) {
  problem p = rotation(f, diffusivity, mixed);
  const double stable = sct_march_stable_step(p.system, NULL);
  const sct_march_options options = {.method = method,
                                     .end = 300 * number * stable,
                                     .diffusion_number = number,
                                     .solve = {.dim = f->cloud.dim}};
  const sct_status status = sct_march(&p.system, &options, NULL, NULL, p.phi, NULL, err);
  *largest = 0;
  for (int64_t i = 0; i < f->cloud.n; i++) *largest = fmax(*largest, fabs(p.phi[i]));
  problem_free(&p);
  return status;
}

static void sound_marches_are_bounded(void **state) {
  (void)state;
  static const int64_t cells[] = {0, 40, 14, 6};
  static const double numbers[] = {1, 50, 10, 50};
  for (int dim = 1; dim <= 3; dim++) {
    for (int scheme = SCT_PS; scheme < SCT_SCHEME_COUNT; scheme++) {
      sct_operator op = sct_operator_default(scheme, 2);
      op.upwind = SCT_UPWIND_COSINE;
      fixture f = fixture_unit(dim, cells[dim], 0.3, 11, &op);
      for (int which = 0; which < 4 * SCT_MARCH_COUNT; which++) {
        const int method = which / 4;
        sct_error err;
        double largest;
        expect_ok(march_rotation(&f, which & 1 ? 1e-3 : 1, (which & 2) != 0, method,
                                 numbers[method], &largest, &err),
                  &err);
        if (largest > 1.2) {
          fail_msg("%s %d-D %s: |phi| = %g", sct_scheme_name(scheme), dim, sct_march_name(method),
                   largest);
        }
      }
      fixture_clear(&f);
    }
  }
}

/* Convection without upwinding at a cell Peclet number of 25: forward Euler amplifies it with any
 * step that the diffusion allows. */
static void unsound_marches_are_seen(void **state) {
  (void)state;
  const sct_operator op = sct_operator_default(SCT_IPS, 2);
  for (int dim = 1; dim <= 2; dim++) {
    fixture f = fixture_unit(dim, dim == 1 ? 40 : 20, 0, 11, &op);
    sct_error err;
    double largest;
    assert_int_equal(march_rotation(&f, 1e-3, false, SCT_FORWARD_EULER, 1, &largest, &err),
                     SCT_E_UNSTABLE);
    assert_true(largest > 1e6 && largest < 1e9);
    assert_int_equal(march_rotation(&f, 1e-3, false, SCT_BACKWARD_EULER, 1, &largest, &err),
                     SCT_OK);
    assert_true(largest < 2);
    fixture_clear(&f);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(errors_of_h16),
      cmocka_unit_test(time_schemes_agree),
      cmocka_unit_test(sound_marches_are_bounded),
      cmocka_unit_test(unsound_marches_are_seen),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
