/* flow_lsmps.c - the Laplacian of a quadratic fit with weight w / r^2, as row_lsmps.c makes it, by
 * normal equations: a moving cloud is even enough for them (condition number of the fit about 10,
 * so 100 of the equations), they need no memory per neighbour, and a row is thrown away after use.
 */
#include <math.h>
#include <string.h>

#include "flow_inside.h"

enum { UNKNOWNS = 5 }; /* x, y, x^2 / 2, x y, y^2 / 2 */

/* sum |l| / sum l above this is no good to step with (stencil.h). */
static const double EXCESS = 1.5;

static void basis(double x, double y, double p[UNKNOWNS]) {
  p[0] = x;
  p[1] = y;
  p[2] = x * x / 2;
  p[3] = x * y;
  p[4] = y * y / 2;
}

/* A = L L^T in place; false at a pivot that is small beside its diagonal entry. */
static bool factor(double a[UNKNOWNS][UNKNOWNS]) {
  for (int i = 0; i < UNKNOWNS; i++) {
    for (int j = 0; j <= i; j++) {
      double s = a[i][j];
      for (int k = 0; k < j; k++) s -= a[i][k] * a[j][k];
      if (i == j && !(s > 1e-4 * a[i][i])) return false;
      a[i][j] = i == j ? sqrt(s) : s / a[j][j];
    }
  }
  return true;
}

static void solve(double l[UNKNOWNS][UNKNOWNS], double b[UNKNOWNS]) {
  for (int i = 0; i < UNKNOWNS; i++) {
    for (int k = 0; k < i; k++) b[i] -= l[i][k] * b[k];
    b[i] /= l[i][i];
  }
  for (int i = UNKNOWNS - 1; i >= 0; i--) {
    for (int k = i + 1; k < UNKNOWNS; k++) b[i] -= l[k][i] * b[k];
    b[i] /= l[i][i];
  }
}

bool flow_lsmps_weights(flow_near *near, double delta) {
  double a[UNKNOWNS][UNKNOWNS], p[UNKNOWNS], sum = 0, size = 0;
  double b[UNKNOWNS] = {0, 0, 1, 0, 1}; /* phi_xx + phi_yy */
  if (near->n <= UNKNOWNS) return false;
  memset(a, 0, sizeof a);
  for (int k = 0; k < near->n; k++) {
    basis(near->x[0][k] / delta, near->x[1][k] / delta, p);
    for (int i = 0; i < UNKNOWNS; i++) {
      for (int j = 0; j <= i; j++) a[i][j] += near->f[k] * p[i] * p[j];
    }
  }
  if (!factor(a)) return false;
  solve(a, b);
  for (int k = 0; k < near->n; k++) {
    basis(near->x[0][k] / delta, near->x[1][k] / delta, p);
    double l = 0;
    for (int i = 0; i < UNKNOWNS; i++) l += b[i] * p[i];
    near->q[k] = near->f[k] * l / (delta * delta);
    sum += near->q[k];
    size += fabs(near->q[k]);
  }
  return size <= EXCESS * sum;
}
