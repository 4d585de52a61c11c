/* bench_stencil: seconds of neighbour search, rows and assembly on jittered clouds.
 *   bench_stencil DIM POINTS [THREADS] [SCHEME DEGREE]
 * prints one JSON line per scheme; bench_pipeline.py sets SciPy beside it. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "scatter/scatter.h"

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void check(sct_status status, const sct_error *err) {
  char room[800];
  if (status == SCT_OK) return;
  fprintf(stderr, "bench_stencil: %s\n", sct_error_message(err, room, sizeof room));
  exit(1);
}

typedef struct {
  sct_cloud cloud;
  double *x, spacing, seconds_order;
  uint8_t *condition;
} bench_cloud;

/* A jittered unit cube, renumbered along the space-filling curve; its boundary is Dirichlet. */
static bench_cloud make_cloud(int dim, int64_t points) {
  const int64_t cells = llround(pow((double)points, 1.0 / dim)) - 1;
  const sct_lattice lattice = {
      .dim = dim, .upper = {1, 1, 1}, .cells = {cells, cells, cells}, .jitter = 0.3, .seed = 1};
  const int64_t n = sct_lattice_count(&lattice);
  bench_cloud c = {.cloud = {.dim = dim, .n = n}, .spacing = sct_lattice_spacing(&lattice)};
  double *raw = malloc((size_t)(n * dim) * sizeof *raw);
  int32_t *order = malloc((size_t)n * sizeof *order);
  sct_group boundary;
  sct_error err;
  uint8_t *on_boundary = calloc((size_t)n, 1);
  c.x = malloc((size_t)(n * dim) * sizeof *c.x);
  c.condition = malloc((size_t)n);
  if (raw == NULL || order == NULL || c.x == NULL || c.condition == NULL || on_boundary == NULL) {
    exit(1);
  }
  sct_lattice_points(&lattice, raw);
  check(sct_lattice_group(&lattice, SCT_SIDE_BOUNDARY, &boundary, &err), &err);
  for (int64_t k = 0; k < boundary.n; k++) on_boundary[boundary.index[k]] = 1;
  const double start = now();
  c.cloud.x = raw;
  check(sct_cloud_order(&c.cloud, order, &err), &err);
  for (int64_t k = 0; k < n; k++) {
    memcpy(c.x + k * dim, raw + (int64_t)order[k] * dim, (size_t)dim * sizeof *raw);
  }
  c.seconds_order = now() - start;
  for (int64_t k = 0; k < n; k++) {
    c.condition[k] = on_boundary[order[k]] ? SCT_DIRICHLET : SCT_INTERIOR;
  }
  c.cloud.x = c.x;
  sct_group_clear(&boundary);
  free(raw);
  free(order);
  free(on_boundary);
  return c;
}

static void run(const bench_cloud *c, const sct_operator *op, const sct_work *work) {
  const int64_t n = c->cloud.n;
  double *mu = malloc((size_t)n * sizeof *mu), *lap = malloc((size_t)n * sizeof *lap);
  sct_search *search = NULL;
  sct_stencil *stencil = NULL;
  sct_system *system = NULL;
  sct_error err;
  if (mu == NULL || lap == NULL) exit(1);
  for (int64_t i = 0; i < n; i++) mu[i] = 1;
  const double t0 = now();
  check(sct_search_build(&c->cloud, op->radius * c->spacing, SCT_SEARCH_AUTO, work, &search, &err),
        &err);
  const double t1 = now();
  check(sct_stencil_build(&c->cloud, search, c->spacing, op, 1000, work, &stencil, &err), &err);
  const double t2 = now();
  check(sct_stencil_apply(stencil, c->x, work, NULL, NULL, lap, &err), &err);
  const double t3 = now();
  const sct_fields fields = {.diffusivity = mu};
  const sct_boundary boundary = {.condition = c->condition};
  check(sct_system_build(stencil, &fields, &boundary, work, &system, &err), &err);
  const double t4 = now();
  const double pairs = (double)sct_stencil_lists(stencil)->start[n] / (double)n;
  printf(
      "{\"dim\": %d, \"points\": %lld, \"scheme\": \"%s\", \"degree\": %d, \"neighbours\": %.2f, "
      "\"order\": %.4f, \"build\": %.4f, \"lists\": %.4f, \"rows\": %.4f, \"assemble\": %.4f, "
      "\"rows_ns_per_point\": %.0f, \"widened\": %lld}\n",
      c->cloud.dim, (long long)n, sct_scheme_name(op->scheme), op->degree, pairs, c->seconds_order,
      t1 - t0, t2 - t1, t3 - t2, t4 - t3, 1e9 * (t3 - t2) / (double)n, (long long)system->widened);
  sct_system_free(&system);
  sct_stencil_free(&stencil);
  sct_search_free(&search);
  free(mu);
  free(lap);
}

int main(int argc, char **argv) {
  const int dim = argc > 1 ? atoi(argv[1]) : 2;
  const int64_t points = argc > 2 ? atoll(argv[2]) : 100000;
  const sct_work work = {.threads = argc > 3 ? atoi(argv[3]) : 1};
  bench_cloud c = make_cloud(dim, points);
  for (int s = SCT_PS; s < SCT_SCHEME_COUNT; s++) {
    if (argc > 4 && s != (int)sct_scheme_find(argv[4])) continue;
    sct_operator op = sct_operator_default((sct_scheme)s, argc > 5 ? atoi(argv[5]) : 2);
    if (argc <= 5) op.radius = 2.1;
    run(&c, &op, &work);
  }
  free(c.x);
  free(c.condition);
  return 0;
}
