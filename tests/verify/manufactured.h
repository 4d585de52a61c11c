/* manufactured.h - a problem with every term, every boundary type and a known answer, steady or in
 * time, in one, two and three dimensions, on any cloud:
 *   phi = sin(1.3 x + 0.4) cos(0.9 y - 0.2) e^(z/2) e^(-decay t),    mu = 1 + 0.3 x + 0.2 y + 0.1
 * z, u = (y - 1/2, 1/2 - x, 0.3),    k = 0.5 + x,    s = phi_t + u . grad phi - div(mu grad phi) +
 * k phi */
#ifndef TESTS_MANUFACTURED_H
#define TESTS_MANUFACTURED_H

#include "fixture.h"

typedef struct {
  double phi, gradient[3], laplacian, mu, u[3], k, source;
} truth;

truth truth_at(int dim, const double *x, double t, double decay);

/* A problem on a fixture's cloud, point by point. */
typedef struct {
  const fixture *f;
  double decay; /* (1 / time) 0: steady */
  double *velocity, *diffusivity, *source, *reaction, *value, *coefficient, *normal, *exact, *phi;
  uint8_t *condition;
} manufactured;

/* Fields of the problem above; Dirichlet at the points that are not f->inside. The fixture is
 * borrowed. */
manufactured manufactured_new(const fixture *f, double decay);
void manufactured_free(manufactured *m);

/* The problem as the library takes it, borrowed. */
sct_fields manufactured_fields(const manufactured *m);
sct_boundary manufactured_boundary(const manufactured *m);

/* Sets the condition of a point, with outward unit normal [dim], or of a side of the lattice. */
void manufactured_set(manufactured *m, int64_t i, sct_condition condition, const double *normal);
void manufactured_side(manufactured *m, sct_side side, sct_condition condition);

/* Solves the steady equation with the fields and values as they stand into m->phi, and returns the
 * root mean square of phi - exact over f->inside. */
double manufactured_steady(manufactured *m);

/* The same error at time `end`, after a march from the exact values at 0 with steps of at most
 * `step`, or of C_D = 1 for forward Euler. */
double manufactured_in_time(manufactured *m, sct_march_method method, double step, double end);

#endif
