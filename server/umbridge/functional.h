/* functional.h - numbers of a solution that a model gives out: point values, mean, norms.
 *
 * Every kind is homogeneous of degree one, q(c phi) = c q(phi), so that by Euler's theorem one
 * matrix Q = dq/dphi gives the value, Q phi, the tangent, Q phi', and the gradient, Q^T sens. Where
 * a norm has a corner (l1 and linf, l2 = 0) Q is that of one of its sides.
 *   values  phi at points, or at places between them: phi_i + grad phi_i . (x - x_i), i being the
 *           nearest point                              mean  (1/n) sum phi_i
 *   l1      (1/n) sum |phi_i|     l2    ((1/n) sum phi_i^2)^(1/2)       linf  max |phi_i|
 * Proof: http.um_bridge
 */
#ifndef SCATTERD_FUNCTIONAL_H
#define SCATTERD_FUNCTIONAL_H

#include "process_solve.h"

typedef struct functional_kind functional_kind;

typedef struct {
  const functional_kind *kind;
  int64_t n;            /* points it is taken of */
  const int32_t *place; /* [n] */
  numbers at;           /* [rows][dim] places between points; data NULL: none */
  int64_t size;         /* numbers it gives */
  char pointer[PROBLEM_POINTER];
} functional;

/* A name of the above (of all points), or {"type", "on": group | [indices], "at": [[x, ..], ..]}.
 * False with complaints. */
bool functional_read(task *t, const item *it, cloud_input *c, functional *f);

/* *rows = Q [size][n], for products only: columns are in no order. False with a complaint (a place
 * outside the cloud) or t->error. */
bool functional_rows(task *t, const functional *f, const solve *s, sct_csr **rows);

#endif
