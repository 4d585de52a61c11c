/* First lesson: Poisson's equation on a jittered cloud of the unit square,
 *
 *   -lap phi = s,   s = 2 pi^2 sin(pi x) sin(pi y),   phi = 0 on the boundary,
 *
 * whose solution is phi = sin(pi x) sin(pi y). The steps come in the order of the headers; each
 * needs what the one before it made. Exits 0 if the error is as small as it has to be.
 *
 *   cc poisson_2d.c $(pkg-config --cflags --libs scatter)
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>

#include "scatter/scatter.h"

enum { CELLS = 40, N = (CELLS + 1) * (CELLS + 1), NEIGHBOURS = 100 };

static const double pi = 3.14159265358979323846;

/* What the equation asks for at each point. */
static double x[N][2], mu[N], source[N], exact[N], phi[N];
static uint8_t condition[N], is_interior[N]; /* SCT_INTERIOR is 0: a point with the equation */

/* cloud.h: (CELLS + 1)^2 points, those inside moved by up to 0.15 spacings in x and y. */
static sct_status make_cloud(sct_lattice *lattice, sct_cloud *cloud, sct_error *err) {
  sct_group boundary;
  *lattice =
      (sct_lattice){.dim = 2, .upper = {1, 1}, .cells = {CELLS, CELLS}, .jitter = 0.3, .seed = 7};
  *cloud = (sct_cloud){.dim = 2, .n = N, .x = &x[0][0]};
  sct_status status = sct_lattice_check(lattice, err);
  if (status != SCT_OK) return status;
  sct_lattice_points(lattice, &x[0][0]);
  status = sct_lattice_group(lattice, SCT_SIDE_BOUNDARY, &boundary, err);
  if (status != SCT_OK) return status;
  for (int64_t k = 0; k < boundary.n; k++) condition[boundary.index[k]] = SCT_DIRICHLET;
  sct_group_clear(&boundary);
  return SCT_OK;
}

static void set_fields(void) {
  for (int i = 0; i < N; i++) {
    exact[i] = sin(pi * x[i][0]) * sin(pi * x[i][1]);
    mu[i] = 1;
    source[i] = 2 * pi * pi * exact[i];
    is_interior[i] = condition[i] == SCT_INTERIOR;
  }
}

/* solve.h: the unknowns are the points that are not Dirichlet; row_of tells where each went. */
static sct_status solve(const sct_system *system, sct_error *err) {
  static double b[N], unknown[N];
  sct_solver *solver = NULL;
  sct_system_rhs(system, phi, b); /* reads phi at Dirichlet points: zero here */
  sct_status status = sct_solver_analyse(system->matrix, NULL, &solver, err);
  if (status == SCT_OK) status = sct_solver_factor(solver, system->matrix, err);
  if (status == SCT_OK) status = sct_solver_solve(solver, b, false, unknown, err);
  for (int64_t row = 0; row < system->unknowns; row++) phi[system->point_of[row]] = unknown[row];
  sct_solver_free(&solver);
  return status;
}

int main(void) {
  sct_lattice lattice;
  sct_cloud cloud;
  sct_search *search = NULL;
  sct_stencil *stencil = NULL;
  sct_system *system = NULL;
  sct_error err = {.code = SCT_OK};
  char room[2 * SCT_ERROR_TEXT];

  /* stencil.h: least squares of second degree, exact for quadratics on any cloud. */
  const sct_operator op = sct_operator_default(SCT_LSMPS, 2);
  const sct_fields fields = {.diffusivity = mu, .source = source};
  const sct_boundary boundary = {.condition = condition};

  bool done = make_cloud(&lattice, &cloud, &err) == SCT_OK;
  const double h = sct_lattice_spacing(&lattice);
  set_fields();
  done = done &&
         sct_search_build(&cloud, op.radius * h, SCT_SEARCH_AUTO, NULL, &search, &err) == SCT_OK &&
         sct_stencil_build(&cloud, search, h, &op, NEIGHBOURS, NULL, &stencil, &err) == SCT_OK &&
         sct_system_build(stencil, &fields, &boundary, NULL, &system, &err) == SCT_OK &&
         solve(system, &err) == SCT_OK;

  /* diagnose.h: how far from the exact solution? */
  const sct_norms norms = sct_norms_of(phi, exact, N, 1, is_interior);
  if (done) printf("%d points, error: l2 %.2e, largest %.2e\n", N, norms.l2, norms.linf);
  if (!done) fprintf(stderr, "%s\n", sct_error_message(&err, room, sizeof room));
  sct_system_free(&system); /* in the opposite order; what was not made is NULL */
  sct_stencil_free(&stencil);
  sct_search_free(&search);
  return done && norms.l2 < 1e-3 ? 0 : 1;
}
