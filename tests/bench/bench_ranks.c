/* Poisson's equation on a jittered cloud of the unit square or cube by many ranks, and the halos of
 * as many parts as one likes:
 *   mpiexec -n N bench_ranks DIM POINTS [PRECONDITIONER [SCHEME [REPEATS]]]
 *   bench_ranks halo DIM POINTS [SCHEME]
 * The first prints a JSON line a rank with the best of REPEATS runs: CPU seconds of the rows,
 * elapsed seconds of set-up, iteration and gathering, CPU seconds of all of these, in which a rank
 * that waits for others spins. The second prints a line for N = 1, 2, 4, ..., 1024 parts.
 * tests/bench/scaling.md has both, and bench_scaling.py the model. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "scatter/scatter.h"

typedef struct {
  sct_lattice lattice;
  sct_cloud cloud;
  sct_operator op;
  double *x, *mu, *source, spacing;
  uint8_t *condition;
} problem;

static double seconds(clockid_t clock) {
  struct timespec t;
  clock_gettime(clock, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void check(sct_status status, const sct_error *err) {
  char room[800];
  if (status == SCT_OK) return;
  fprintf(stderr, "bench_ranks: %s\n", sct_error_message(err, room, sizeof room));
  exit(1);
}

static void *take(int64_t n, size_t size) {
  void *memory = calloc((size_t)n, size);
  if (memory != NULL) return memory;
  fputs("bench_ranks: out of memory\n", stderr);
  exit(1);
}

static bool is_on_rim(const problem *p, int64_t i) {
  bool rim = false;
  for (int a = 0; a < p->cloud.dim; a++) {
    const double x = p->x[i * p->cloud.dim + a];
    rim = rim || x <= 0 || x >= 1;
  }
  return rim;
}

static problem problem_new(int dim, double points, const char *scheme) {
  problem p = {.op = sct_operator_default(sct_scheme_find(scheme), 2)};
  const int64_t cells = (int64_t)round(pow(points, 1.0 / dim)) - 1;
  p.lattice = (sct_lattice){.dim = dim, .jitter = 0.3, .seed = 1};
  for (int a = 0; a < dim; a++) {
    p.lattice.upper[a] = 1;
    p.lattice.cells[a] = cells;
  }
  const int64_t n = sct_lattice_count(&p.lattice);
  p.x = take(n * dim, sizeof *p.x);
  p.mu = take(n, sizeof *p.mu);
  p.source = take(n, sizeof *p.source);
  p.condition = take(n, 1);
  sct_lattice_points(&p.lattice, p.x);
  p.cloud = (sct_cloud){dim, n, p.x};
  p.spacing = sct_lattice_spacing(&p.lattice);
  for (int64_t i = 0; i < n; i++) {
    p.mu[i] = p.source[i] = 1;
    p.condition[i] = is_on_rim(&p, i) ? SCT_DIRICHLET : SCT_INTERIOR;
  }
  return p;
}

static void problem_free(problem *p) {
  free(p->x);
  free(p->mu);
  free(p->source);
  free(p->condition);
}

/* ---- halos ---- */

static void print_halo(const problem *p, int parts) {
  sct_partition *partition;
  sct_error err;
  int64_t all = 0, most = 0, own = 0;
  check(sct_partition_build(&p->cloud, parts, false, &partition, &err), &err);
  for (int k = 0; k < parts; k++) {
    sct_part *part;
    check(
        sct_part_build(&p->cloud, partition, k, p->op.radius * p->spacing, NULL, NULL, &part, &err),
        &err);
    const int64_t halo = part->n - part->own;
    all += halo;
    most = halo > most ? halo : most;
    own = part->own > own ? part->own : own;
    sct_part_free(&part);
  }
  printf(
      "{\"dim\": %d, \"points\": %lld, \"parts\": %d, \"own_most\": %lld, \"halo\": %lld, "
      "\"halo_most\": %lld}\n",
      p->cloud.dim, (long long)p->cloud.n, parts, (long long)own, (long long)all, (long long)most);
  sct_partition_free(&partition);
}

static int halos(int count, char **argv) {
  problem p = problem_new(atoi(argv[0]), atof(argv[1]), count > 2 ? argv[2] : "lsmps");
  for (int parts = 1; parts <= 1024; parts *= 2) print_halo(&p, parts);
  problem_free(&p);
  return 0;
}

/* ---- solves ---- */

typedef struct {
  double partition, rows, setup, solve, exchange, cpu; /* (s) */
  int iterations;
} times;

static void least(double *best, double value) {
  *best = *best > 0 && *best < value ? *best : value;
}

/* The rows alone, on this rank's processor, whatever others do. */
static double rows_of(const problem *p, const sct_partition *partition, int rank,
                      const sct_fields *fields, const sct_boundary *boundary) {
  const sct_part_problem whole = {&p->cloud, partition, p->spacing, &p->op, 500, fields, boundary};
  sct_part_system *s;
  sct_error err;
  const double begin = seconds(CLOCK_THREAD_CPUTIME_ID);
  check(sct_part_assemble(&whole, rank, NULL, &s, &err), &err);
  const double end = seconds(CLOCK_THREAD_CPUTIME_ID);
  sct_part_system_free(&s);
  return end - begin;
}

static void run(const problem *p, sct_ranks *ranks, const char *preconditioner, times *best,
                sct_solve_report *solve, sct_ranks_report *report) {
  const sct_fields fields = {.diffusivity = p->mu, .source = p->source};
  const sct_boundary boundary = {.condition = p->condition};
  const sct_solve_options options = {.dim = p->cloud.dim, .preconditioner = preconditioner};
  double *phi = take(p->cloud.n, sizeof *phi);
  sct_partition *partition;
  sct_error err;
  const double begin = seconds(CLOCK_THREAD_CPUTIME_ID);
  check(sct_partition_build(&p->cloud, sct_ranks_count(ranks), false, &partition, &err), &err);
  least(&best->partition, seconds(CLOCK_THREAD_CPUTIME_ID) - begin);
  least(&best->rows, rows_of(p, partition, sct_ranks_rank(ranks), &fields, &boundary));
  const sct_part_problem whole = {&p->cloud, partition, p->spacing, &p->op,
                                  500,       &fields,   &boundary};
  const double before = seconds(CLOCK_PROCESS_CPUTIME_ID);
  check(sct_ranks_solve(ranks, &whole, &options, NULL, phi, solve, report, &err), &err);
  least(&best->cpu, seconds(CLOCK_PROCESS_CPUTIME_ID) - before);
  least(&best->setup, solve->seconds_factor);
  least(&best->solve, solve->seconds_solve);
  least(&best->exchange, report->seconds_exchange);
  best->iterations = solve->iterations;
  sct_partition_free(&partition);
  free(phi);
}

static int solves(int count, char **argv) {
  const char *preconditioner = count > 2 ? argv[2] : NULL;
  const int repeats = count > 4 ? atoi(argv[4]) : 3;
  problem p = problem_new(atoi(argv[0]), atof(argv[1]), count > 3 ? argv[3] : "lsmps");
  times best = {0};
  sct_ranks *ranks;
  sct_solve_report solve;
  sct_ranks_report report;
  sct_error err;
  check(sct_ranks_open(&ranks, &err), &err);
  for (int k = 0; k < repeats; k++) run(&p, ranks, preconditioner, &best, &solve, &report);
  printf(
      "{\"rank\": %d, \"ranks\": %d, \"dim\": %d, \"points\": %lld, \"preconditioner\": \"%s\", "
      "\"iterations\": %d, \"halo\": %lld, \"partition\": %.4f, \"rows\": %.4f, \"setup\": %.4f, "
      "\"solve\": %.4f, \"exchange\": %.4f, \"cpu\": %.4f}\n",
      sct_ranks_rank(ranks), sct_ranks_count(ranks), p.cloud.dim, (long long)p.cloud.n,
      solve.preconditioner, best.iterations, (long long)report.halo, best.partition, best.rows,
      best.setup, best.solve, best.exchange, best.cpu);
  sct_ranks_close(&ranks);
  problem_free(&p);
  return 0;
}

int main(int argc, char **argv) {
  if (argc > 3 && strcmp(argv[1], "halo") == 0) return halos(argc - 2, argv + 2);
  if (argc > 2) return solves(argc - 1, argv + 1);
  fputs(
      "usage: mpiexec -n N bench_ranks DIM POINTS [PRECONDITIONER [SCHEME [REPEATS]]]\n"
      "       bench_ranks halo DIM POINTS [SCHEME]\n",
      stderr);
  return 2;
}
