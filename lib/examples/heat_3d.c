/* Second lesson: the heat equation in a jittered cube, marched in time,
 *
 *   d phi / dt = lap phi,   phi = 0 on the boundary,   phi(0) = sin(pi x) sin(pi y) sin(pi z),
 *
 * whose solution is phi(t) = exp(-3 pi^2 t) phi(0). Up to the system it is the first lesson
 * (poisson_2d.c) with a third coordinate; then march.h takes over from solve.h. Exits 0 if the
 * error is as small as it has to be.
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>

#include "scatter/scatter.h"

enum { CELLS = 12, SIDE = CELLS + 1, N = SIDE * SIDE * SIDE, NEIGHBOURS = 200 };

static const double pi = 3.14159265358979323846;
static double x[N][3], mu[N], start[N], phi[N];
static uint8_t condition[N], is_interior[N];

static double exact_factor(double t) {
  return exp(-3 * pi * pi * t);
}

/* march.h calls this at every save time, and at the end: a place to write files, or to compare. */
static sct_status compare(void *context, double t, const double *values, sct_error *err) {
  static double exact[N];
  double *worst = context;
  (void)err;
  for (int i = 0; i < N; i++) exact[i] = exact_factor(t) * start[i];
  const sct_norms norms = sct_norms_of(values, exact, N, 1, is_interior);
  printf("t = %.3f: largest value %.4f, relative error %.2e\n", t, exact_factor(t),
         norms.l2_relative);
  *worst = fmax(*worst, norms.l2_relative);
  return SCT_OK;
}

/* Points, boundary and initial values; the lattice has been checked. */
static sct_status set_problem(const sct_lattice *lattice, sct_error *err) {
  sct_group boundary;
  sct_lattice_points(lattice, &x[0][0]);
  const sct_status status = sct_lattice_group(lattice, SCT_SIDE_BOUNDARY, &boundary, err);
  if (status != SCT_OK) return status;
  for (int64_t k = 0; k < boundary.n; k++) condition[boundary.index[k]] = SCT_DIRICHLET;
  sct_group_clear(&boundary);
  for (int i = 0; i < N; i++) {
    mu[i] = 1;
    is_interior[i] = condition[i] == SCT_INTERIOR;
    start[i] = is_interior[i] ? sin(pi * x[i][0]) * sin(pi * x[i][1]) * sin(pi * x[i][2]) : 0;
    phi[i] = start[i];
  }
  return SCT_OK;
}

int main(void) {
  const sct_lattice lattice = {
      .dim = 3, .upper = {1, 1, 1}, .cells = {CELLS, CELLS, CELLS}, .jitter = 0.3, .seed = 7};
  const sct_cloud cloud = {.dim = 3, .n = N, .x = &x[0][0]};
  const double h = sct_lattice_spacing(&lattice), save[] = {0.01, 0.02};
  const sct_operator op = sct_operator_default(SCT_LSMPS, 2);
  const sct_fields fields = {.diffusivity = mu};
  const sct_boundary boundary = {.condition = condition};
  const sct_work work = {.threads = 2}; /* of the search and the assembly */
  sct_search *search = NULL;
  sct_stencil *stencil = NULL;
  sct_system *system = NULL;
  sct_march_report report;
  sct_error err = {.code = SCT_OK};
  char room[2 * SCT_ERROR_TEXT];
  double worst = 0;

  /* Second order in time; the step matrix is factored once, as it does not change. */
  const sct_march_options march = {.method = SCT_CRANK_NICOLSON,
                                   .end = 0.04,
                                   .step = 0.002,
                                   .save = save,
                                   .saves = 2,
                                   .solve = {.dim = 3}};
  const sct_march_problem problem = {.context = &worst, .save = compare};

  const bool done =
      sct_lattice_check(&lattice, &err) == SCT_OK && set_problem(&lattice, &err) == SCT_OK &&
      sct_search_build(&cloud, op.radius * h, SCT_SEARCH_AUTO, &work, &search, &err) == SCT_OK &&
      sct_stencil_build(&cloud, search, h, &op, NEIGHBOURS, &work, &stencil, &err) == SCT_OK &&
      sct_system_build(stencil, &fields, &boundary, &work, &system, &err) == SCT_OK &&
      sct_march(&system, &march, &problem, &work, phi, &report, &err) == SCT_OK;
  if (done) printf("%d points, %d steps\n", N, (int)report.steps);
  if (!done) fprintf(stderr, "%s\n", sct_error_message(&err, room, sizeof room));
  sct_system_free(&system);
  sct_stencil_free(&stencil);
  sct_search_free(&search);
  return done && report.factorisations == 1 && worst < 0.05 ? 0 : 1;
}
