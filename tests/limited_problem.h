/* limited_problem.h - steady convection and diffusion on a lattice cloud, as the tests of `limited`
 * pose it. Include cmocka.h before. */
#ifndef TESTS_LIMITED_PROBLEM_H
#define TESTS_LIMITED_PROBLEM_H

#include "fixture.h"

/* What is posed, at a point x [dim]. */
typedef struct {
  void (*velocity)(const double *x, double *u);       /* u [dim] out */
  double (*value)(const double *x);                   /* Dirichlet values, on the boundary */
  double (*source)(const double *x, double mu);       /* NULL: none */
  bool (*is_outlet)(const double *x, double *normal); /* zero gradient there; NULL: nowhere */
  double mu;
} posed;

typedef struct {
  fixture f;
  double *velocity, *mu, *value, *source, *normal, *phi;
  uint8_t *condition;
  sct_system *system;
  sct_limited_report report;
} limited_problem;

/* Poses and assembles; unknowns of phi are 0. */
limited_problem limited_problem_new(const posed *p, const sct_lattice *lattice,
                                    const sct_operator *op);
void limited_problem_clear(limited_problem *p);

/* Solves into phi, with the report in *p. */
sct_status limited_problem_solve(limited_problem *p, const sct_limited_options *options,
                                 sct_error *err);

/* A scheme with upwind `limited`. */
sct_operator limited_operator(sct_scheme scheme);

#endif
