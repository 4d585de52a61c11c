/* equation.h - an equation on a jittered lattice with all kinds of conditions and random data, and
 * a random change of these: what derivatives are proved on. */
#ifndef TESTS_EQUATION_H
#define TESTS_EQUATION_H

#include "../fixture.h"

typedef struct {
  fixture f;
  int64_t n;
  int dim;
  uint8_t *condition;               /* left dirichlet, right robin, bottom neumann, top dirichlet */
  double *normal;                   /* [n][dim] */
  sct_data data, change;            /* every member */
  double *initial, *initial_change; /* [n] */
} equation;

/* `still`: no velocity anywhere, but a change of it. */
equation equation_make(int dim, const sct_operator *op, bool still, uint64_t seed);
void equation_clear(equation *e);

/* The fields and conditions of data + h change; `room` owns the arrays. */
typedef struct {
  sct_data at;
  sct_fields fields;
  sct_boundary boundary;
} equation_data;
equation_data equation_at(const equation *e, double h);
void equation_data_clear(equation_data *d);

sct_system *equation_system(const equation *e, double h);

/* Sum of a . b over all members of two data. */
double equation_dot(const equation *e, const sct_data *a, const sct_data *b);
sct_data equation_zeros(const equation *e);
void equation_free(sct_data *d);

#endif
