/* Time of the search on a jittered lattice:
 *   bench_search DIM POINTS RADIUS THREADS REPEATS ORDER > line of numbers
 * RADIUS in spacings; ORDER lattice, random or curve. Prints n, neighbours per point and the best
 * seconds of build, lists, nearest and of ordering along the curve: of the processor with one
 * thread, of the clock with more. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "scatter/search.h"

static clockid_t watch;

static double seconds(void) {
  struct timespec t;
  clock_gettime(watch, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void must(sct_status status, const sct_error *err) {
  if (status == SCT_OK) return;
  fprintf(stderr, "%s\n", err->text);
  exit(1);
}

static void *room(size_t bytes) {
  void *memory = malloc(bytes);
  if (memory == NULL) exit(1);
  return memory;
}

/* The points order[0], order[1], ... */
static double *reorder(const sct_cloud *cloud, const int32_t *order) {
  size_t row = (size_t)cloud->dim * sizeof(double);
  double *x = room((size_t)cloud->n * row);
  for (int64_t k = 0; k < cloud->n; k++) {
    memcpy(x + k * cloud->dim, cloud->x + (int64_t)order[k] * cloud->dim, row);
  }
  return x;
}

static void shuffle(int32_t *order, int64_t n) {
  srand48(1);
  for (int64_t i = 0; i < n; i++) order[i] = (int32_t)i;
  for (int64_t i = n - 1; i > 0; i--) {
    int64_t j = (int64_t)(drand48() * (double)(i + 1));
    int32_t swap = order[i];
    order[i] = order[j];
    order[j] = swap;
  }
}

typedef struct {
  double build, lists, nearest, order, neighbours;
} result;

static void best(double *least, double start) {
  double t = seconds() - start;
  if (t < *least) *least = t;
}

static void run(const sct_cloud *cloud, double radius, const sct_work *work, result *r) {
  sct_error err;
  sct_search *search;
  sct_lists *lists;
  double *distance = room((size_t)cloud->n * sizeof *distance);
  double start = seconds();
  must(sct_search_build(cloud, radius, SCT_SEARCH_AUTO, work, &search, &err), &err);
  best(&r->build, start);
  start = seconds();
  must(sct_search_lists(search, radius, NULL, 100000, work, &lists, &err), &err);
  best(&r->lists, start);
  start = seconds();
  must(sct_search_nearest(search, work, distance, &err), &err);
  best(&r->nearest, start);
  r->neighbours = (double)lists->start[lists->n] / (double)lists->n;
  sct_lists_free(&lists);
  sct_search_free(&search);
  free(distance);
}

int main(int argc, char **argv) {
  if (argc != 7) return 2;
  const int dim = atoi(argv[1]), repeats = atoi(argv[5]);
  const sct_work work = {.threads = atoi(argv[4])};
  watch = work.threads == 1 ? CLOCK_PROCESS_CPUTIME_ID : CLOCK_MONOTONIC;
  const int64_t cells = llround(pow(atof(argv[2]), 1.0 / dim)) - 1;
  sct_lattice l = {dim, {0, 0, 0}, {1, 1, 1}, {cells, cells, cells}, 0.3, 1};
  sct_error err;
  must(sct_lattice_check(&l, &err), &err);
  sct_cloud cloud = {dim, sct_lattice_count(&l), NULL};
  double *x = room((size_t)(cloud.n * dim) * sizeof *x);
  int32_t *order = room((size_t)cloud.n * sizeof *order);
  sct_lattice_points(&l, x);
  cloud.x = x;
  result r = {INFINITY, INFINITY, INFINITY, INFINITY, 0};
  if (strcmp(argv[6], "lattice") != 0) {
    shuffle(order, cloud.n);
    cloud.x = reorder(&cloud, order);
    free(x);
    x = (double *)(uintptr_t)cloud.x;
  }
  double start = seconds();
  must(sct_cloud_order(&cloud, order, &err), &err);
  best(&r.order, start);
  if (strcmp(argv[6], "curve") == 0) cloud.x = reorder(&cloud, order);
  for (int k = 0; k < repeats; k++) run(&cloud, atof(argv[3]) * sct_lattice_spacing(&l), &work, &r);
  printf("%lld %.3f %.6f %.6f %.6f %.6f\n", (long long)cloud.n, r.neighbours, r.build, r.lists,
         r.nearest, r.order);
  if (cloud.x != x) free((void *)(uintptr_t)cloud.x);
  free(x);
  free(order);
  return 0;
}
