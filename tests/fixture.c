#include "fixture.h"

#include <stdlib.h>
#include <string.h>

void expect_ok(sct_status status, const sct_error *err) {
  char room[SCT_ERROR_TEXT * 2];
  if (status != SCT_OK) fail_msg("%s", sct_error_message(err, room, sizeof room));
}

void *fixture_alloc(int64_t n, size_t size) {
  void *memory = calloc((size_t)(n > 0 ? n : 1), size);
  assert_non_null(memory);
  return memory;
}

double fixture_random(uint64_t *state) {
  uint64_t z = *state += 0x9e3779b97f4a7c15u;
  z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
  z = (z ^ z >> 27) * 0x94d049bb133111ebu;
  return (double)((z ^ z >> 31) >> 11) * 0x1p-53;
}

static void prepare(fixture *f, const sct_operator *op) {
  sct_error err;
  expect_ok(
      sct_search_build(&f->cloud, op->radius * f->spacing, SCT_SEARCH_AUTO, NULL, &f->search, &err),
      &err);
  expect_ok(sct_stencil_build(&f->cloud, f->search, f->spacing, op, FIXTURE_NEIGHBOURS, NULL,
                              &f->stencil, &err),
            &err);
}

fixture fixture_lattice(const sct_lattice *lattice, const sct_operator *op) {
  fixture f = {.lattice = *lattice};
  sct_group interior;
  sct_error err;
  expect_ok(sct_lattice_check(lattice, &err), &err);
  f.cloud.dim = lattice->dim;
  f.cloud.n = sct_lattice_count(lattice);
  f.cloud.x = f.x = fixture_alloc(f.cloud.n * lattice->dim, sizeof *f.x);
  sct_lattice_points(lattice, f.x);
  f.spacing = sct_lattice_spacing(lattice);
  f.inside = fixture_alloc(f.cloud.n, 1);
  expect_ok(sct_lattice_group(lattice, SCT_SIDE_INTERIOR, &interior, &err), &err);
  for (int64_t k = 0; k < interior.n; k++) f.inside[interior.index[k]] = 1;
  sct_group_clear(&interior);
  prepare(&f, op);
  return f;
}

fixture fixture_unit(int dim, int64_t cells, double jitter, uint64_t seed, const sct_operator *op) {
  sct_lattice lattice = {.dim = dim,
                         .upper = {1, 1, 1},
                         .cells = {cells, cells, cells},
                         .jitter = jitter,
                         .seed = seed};
  return fixture_lattice(&lattice, op);
}

fixture fixture_points(int dim, int64_t n, const double *x, double spacing,
                       const sct_operator *op) {
  fixture f = {.spacing = spacing};
  f.cloud = (sct_cloud){.dim = dim, .n = n};
  f.cloud.x = f.x = fixture_alloc(n * dim, sizeof *f.x);
  memcpy(f.x, x, (size_t)(n * dim) * sizeof *x);
  f.inside = fixture_alloc(n, 1);
  memset(f.inside, 1, (size_t)n);
  prepare(&f, op);
  return f;
}

void fixture_clear(fixture *f) {
  sct_stencil_free(&f->stencil);
  sct_search_free(&f->search);
  free(f->x);
  free(f->inside);
  memset(f, 0, sizeof *f);
}
