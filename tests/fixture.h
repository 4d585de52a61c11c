/* fixture.h - a cloud with its search and stencil, as most tests need it. */
#ifndef SCATTER_TEST_FIXTURE_H
#define SCATTER_TEST_FIXTURE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "scatter/scatter.h"

typedef struct {
  sct_lattice lattice;
  sct_cloud cloud;
  double *x; /* [n][dim] */
  double spacing;
  uint8_t *inside; /* [n] 1: not on the boundary */
  sct_search *search;
  sct_stencil *stencil;
} fixture;

enum { FIXTURE_NEIGHBOURS = 2000 };

/* Fails the test with the error's message unless status is SCT_OK. */
void expect_ok(sct_status status, const sct_error *err);

/* Unit interval, square or cube of `cells` per side. */
fixture fixture_unit(int dim, int64_t cells, double jitter, uint64_t seed, const sct_operator *op);

/* Any lattice. */
fixture fixture_lattice(const sct_lattice *lattice, const sct_operator *op);

/* Points x [n][dim], which is copied; all count as inside. */
fixture fixture_points(int dim, int64_t n, const double *x, double spacing, const sct_operator *op);
void fixture_clear(fixture *f);

/* A pseudo-random number in [0, 1), reproducible: SplitMix64. */
double fixture_random(uint64_t *state);

/* malloc that fails the test rather than return NULL; zeroed. */
void *fixture_alloc(int64_t n, size_t size);

#endif
