/* kernel.h - weights w(q) of a neighbour at distance r, q = r / r_e (numerics: no unit).
 *
 * All operators of this library are ratios of sums of w, so a constant factor of w cancels: the
 * table holds the dimensionless profile. The paper's normalised kernel is w(r / r_e) / r_e.
 * Every kernel is 0 for q >= 1.
 */
#ifndef SCATTER_KERNEL_H
#define SCATTER_KERNEL_H

#include "scatter/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
  const char *name;
  double (*w)(double q);                                    /* weight, q > 0 */
  double (*slope)(double q);                                /* dw/dq */
  void (*fill)(int64_t n, const double *q, double *weight); /* weight[k] = w(q[k]) */
  bool singular;                                            /* w grows without bound at q = 0 */
  const char *source;                                       /* where it comes from */
} sct_kernel;

/* The table, in a fixed order, and its size:
 *   center        (A + C q^2 + D q^3 + E q^4), s = sqrt 2, Z = 512 s - 745, A = (480 s - 705)/Z,
 *                 C = (1515 - 960 s)/Z, D = -210/Z, E = (480 s - 600)/Z        [H11] eq. 19
 *   rational      1/q - 1                                          [H11] ref. 20, [H16] eq. 3
 *   bell          2 - 4 q^2 for q < 1/2, (2 q - 2)^2 beyond        [H11] ref. 10
 *   spiky         (1 - q)^3                                        [H11] ref. 22
 *   cubic-spline  2/3 - 4 q^2 + 4 q^3 for q < 1/2, 4/3 (1 - q)^3 beyond   Belytschko et al. 1996
 *   quartic-spline 1 - 6 q^2 + 8 q^3 - 3 q^4                               Belytschko et al. 1996
 *   exponential   e^(-(q/c)^2), c = 0.4                                    Belytschko et al. 1996
 *   wendland-c2   (1 - q)^4 (4 q + 1)                                      Wendland 1995
 *   gaussian      e^(-9 q^2), cut at q = 1 (three lengths of its decay)
 * exponential and gaussian are cut at q = 1 where they are not quite 0 (2e-3, 1e-4).
 * Proof: unit.kernel (slope against differences, value at the support), verify.kernel.center
 * (w(1) = w'(1) = w'(0) = 0, integral over (-1, 1) = 1, w(1/sqrt 2) = w(1/2) / 4) */
const sct_kernel *sct_kernel_at(int k); /* NULL past the end */
int sct_kernel_count(void);

/* Row with that name, or NULL. */
const sct_kernel *sct_kernel_find(const char *name);

#ifdef __cplusplus
}
#endif
#endif
