/* Third lesson: what a scattered cloud does to a Laplacian that is made for lattices.
 *
 * On a line of points displaced at random the Laplacian of ps contains a convection with an
 * artificial velocity u_N (diagnose.h): it sees lap x = u_N where there is nothing to see, and more
 * of it on finer clouds, because u_N h stays what it is. ips subtracts it. Exits 0 if
 *
 *   ps   lap x = u_N at every point, with a cell Reynolds number rms(u_N) h = 2.17 jitter,
 *   ips  lap x = 0
 *
 * on clouds of 1000 and of 100 000 cells ([H16] eq. 14, 20, 37b).
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>

#include "scatter/scatter.h"

enum { MOST = 100001, NEIGHBOURS = 20 };
static const double jitter = 0.05;

static double x[MOST], u[MOST], laplacian[MOST], nothing[MOST];

/* The Laplacian of x by `scheme`, and the artificial velocity of the cloud. */
static sct_status laplacian_of_x(const sct_cloud *cloud, double h, sct_scheme scheme,
                                 sct_error *err) {
  const sct_operator op = sct_operator_default(scheme, 2);
  const sct_diagnosis diagnosis = {.artificial_velocity = u};
  sct_search *search = NULL;
  sct_stencil *stencil = NULL;
  sct_status status = sct_search_build(cloud, op.radius * h, SCT_SEARCH_AUTO, NULL, &search, err);
  if (status == SCT_OK) {
    status = sct_stencil_build(cloud, search, h, &op, NEIGHBOURS, NULL, &stencil, err);
  }
  if (status == SCT_OK) status = sct_stencil_apply(stencil, x, NULL, NULL, NULL, laplacian, err);
  if (status == SCT_OK) status = sct_diagnose(stencil, NULL, &diagnosis, err);
  sct_stencil_free(&stencil);
  sct_search_free(&search);
  return status;
}

/* Both schemes on a cloud of so many cells. False if they do not do what they should. */
static bool compare(int cells) {
  const sct_lattice lattice = {
      .dim = 1, .upper = {1}, .cells = {cells}, .jitter = jitter, .seed = 7};
  const sct_cloud cloud = {.dim = 1, .n = cells + 1, .x = x};
  const double h = sct_lattice_spacing(&lattice);
  const int64_t inside = cells - 1; /* points 1 .. cells - 1: at the ends all is one-sided */
  double convection = 0;
  sct_norms ps, ips;
  sct_error err;
  char room[2 * SCT_ERROR_TEXT];
  sct_status status = sct_lattice_check(&lattice, &err);
  if (status == SCT_OK) {
    sct_lattice_points(&lattice, x);
    status = laplacian_of_x(&cloud, h, SCT_PS, &err);
    ps = sct_norms_of(laplacian + 1, u + 1, inside, 1, NULL);
    convection = sct_range_of(laplacian + 1, inside, 1, NULL).rms;
  }
  if (status == SCT_OK) {
    status = laplacian_of_x(&cloud, h, SCT_IPS, &err);
    ips = sct_norms_of(laplacian + 1, nothing, inside, 1, NULL);
  }
  if (status != SCT_OK) {
    fprintf(stderr, "%s\n", sct_error_message(&err, room, sizeof room));
    return false;
  }
  const double velocity = sct_range_of(u + 1, inside, 1, NULL).rms;
  printf("%6d cells: lap x of ps %9.2f (u_N %9.2f, u_N h / jitter %.3f), of ips %.1e\n", cells,
         convection, velocity, velocity * h / jitter, ips.l2);
  return ps.linf < 1e-8 * velocity && ips.linf < 1e-8 * velocity &&
         fabs(velocity * h / jitter - 2.17) < 0.2;
}

int main(void) {
  const bool coarse = compare(1000), fine = compare(100000);
  return coarse && fine ? 0 : 1;
}
