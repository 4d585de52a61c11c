#include "clouds.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const char *const cloud_names[CLOUDS] = {"uniform", "lattice", "clustered", "graded",
                                         "line",    "plane",   "outlier",   "speck"};

double cloud_random(uint64_t *stream) {
  *stream += UINT64_C(0x9e3779b97f4a7c15);
  uint64_t z = *stream;
  z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
  z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
  return (double)((z ^ z >> 31) >> 11) * 0x1p-53;
}

static double *room(int64_t entries) {
  double *x = malloc((size_t)entries * sizeof *x);
  if (x == NULL) abort();
  return x;
}

static sct_cloud lattice(int dim, int64_t n, uint64_t seed) {
  int64_t side = (int64_t)floor(pow((double)n, 1.0 / dim) + 1e-9) - 1;
  sct_lattice l = {dim, {0, 0, 0}, {1, 1, 1}, {side, side, side}, 0.3, seed};
  double *x = room(sct_lattice_count(&l) * dim);
  sct_lattice_points(&l, x);
  return (sct_cloud){dim, sct_lattice_count(&l), x};
}

static void uniform(int dim, int64_t n, uint64_t *stream, double *x) {
  for (int64_t e = 0; e < n * dim; e++) x[e] = cloud_random(stream);
}

static void clustered(int dim, int64_t n, uint64_t *stream, double *x) {
  uniform(dim, n, stream, x);
  for (int64_t i = 10; i < n; i++) {
    if (i % 10 == 0) continue; /* the background */
    for (int k = 0; k < dim; k++) x[i * dim + k] = x[i % 10 * dim + k] + 1e-2 * x[i * dim + k];
  }
}

static void graded(int dim, int64_t n, uint64_t *stream, double *x) {
  for (int64_t i = 0; i < n; i++) {
    double scale = pow(10, -9 * cloud_random(stream));
    for (int k = 0; k < dim; k++) x[i * dim + k] = scale * cloud_random(stream);
  }
}

static void line(int dim, int64_t n, uint64_t *stream, double *x) {
  for (int64_t i = 0; i < n; i++) {
    double t = cloud_random(stream);
    for (int k = 0; k < dim; k++) x[i * dim + k] = t * (k + 1);
  }
}

static void plane(int dim, int64_t n, uint64_t *stream, double *x) {
  uniform(dim, n, stream, x);
  for (int64_t i = 0; i < n && dim > 1; i++) x[i * dim + dim - 1] = 0;
}

static void outlier(int dim, int64_t n, uint64_t *stream, double *x) {
  uniform(dim, n, stream, x);
  for (int k = 0; k < dim; k++) x[n / 2 * dim + k] = 1e12;
}

static void speck(int dim, int64_t n, uint64_t *stream, double *x) {
  for (int64_t e = 0; e < n * dim; e++) x[e] = 0.5 + 1e-9 * cloud_random(stream);
}

static void (*const fill[CLOUDS])(int dim, int64_t n, uint64_t *stream, double *x) = {
    uniform, NULL, clustered, graded, line, plane, outlier, speck};

sct_cloud cloud_make(int kind, int dim, int64_t n, uint64_t seed) {
  if (kind == CLOUD_LATTICE) return lattice(dim, n, seed);
  double *x = room(n * dim);
  fill[kind](dim, n, &seed, x);
  return (sct_cloud){dim, n, x};
}

void cloud_free(sct_cloud *cloud) {
  free((void *)(uintptr_t)cloud->x);
  memset(cloud, 0, sizeof *cloud);
}
