/* Poisson's equation on a jittered cloud of the unit square or cube, phase by phase:
 *   bench_stencil DIM POINTS [THREADS [REPEATS [SOLVE [SCHEME [DEGREE [METHOD
 * [PRECONDITIONER]]]]]]] prints one JSON line per scheme with the best seconds of REPEATS runs: of
 * the processor with one thread, of the clock with more, and the memory of the process at its peak,
 * MB, before the solve and in all. SOLVE 0 leaves out the solve, METHOD and PRECONDITIONER are
 * those of scatter/solve.h. bench_pipeline.py sets SciPy beside it. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

#include "scatter/scatter.h"

static const double pi = 3.14159265358979323846;
static clockid_t watch;

static double now(void) {
  struct timespec t;
  clock_gettime(watch, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void check(sct_status status, const sct_error *err) {
  char room[800];
  if (status == SCT_OK) return;
  fprintf(stderr, "bench_stencil: %s\n", sct_error_message(err, room, sizeof room));
  exit(1);
}

static void *memory_for(int64_t n, size_t size) {
  void *memory = calloc((size_t)n, size);
  if (memory == NULL) exit(1);
  return memory;
}

/* order along the curve; cells of the search; neighbour lists; rows alone, applied to a field; rows
 * into a matrix; analysis and factors; one solve */
#define PHASES(X) X(order) X(search) X(lists) X(apply) X(assemble) X(factor) X(solve)
enum {
#define PHASE_ENUM(name) PHASE_##name,
  PHASES(PHASE_ENUM)
#undef PHASE_ENUM
      PHASE_COUNT
};

typedef struct {
  int dim;
  int64_t n;
  double spacing, *raw, *x, *mu, *source, *exact, *phi;
  uint8_t *on_boundary, *condition, *inside;
  int32_t *order;
  double seconds[PHASE_COUNT], l2;
  int64_t neighbours, widened;
  const char *method, *preconditioner; /* asked for */
  sct_solve_report report;
  double peak_before, peak;
} bench;

/* The cloud in lattice order, and the room that a run needs. */
static bench bench_new(int dim, int64_t points) {
  const int64_t cells = llround(pow((double)points, 1.0 / dim)) - 1;
  const sct_lattice lattice = {
      .dim = dim, .upper = {1, 1, 1}, .cells = {cells, cells, cells}, .jitter = 0.3, .seed = 1};
  const int64_t n = sct_lattice_count(&lattice);
  sct_group boundary;
  sct_error err;
  bench b = {.dim = dim, .n = n, .spacing = sct_lattice_spacing(&lattice)};
  double **const arrays[] = {&b.mu, &b.source, &b.exact, &b.phi};
  uint8_t **const flags[] = {&b.on_boundary, &b.condition, &b.inside};
  for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++) {
    *arrays[k] = memory_for(n, sizeof(double));
  }
  for (size_t k = 0; k < sizeof flags / sizeof *flags; k++) *flags[k] = memory_for(n, 1);
  b.raw = memory_for(n * dim, sizeof *b.raw);
  b.x = memory_for(n * dim, sizeof *b.x);
  b.order = memory_for(n, sizeof *b.order);
  sct_lattice_points(&lattice, b.raw);
  check(sct_lattice_group(&lattice, SCT_SIDE_BOUNDARY, &boundary, &err), &err);
  for (int64_t k = 0; k < boundary.n; k++) b.on_boundary[boundary.index[k]] = 1;
  sct_group_clear(&boundary);
  return b;
}

static void bench_free(bench *b) {
  double *const arrays[] = {b->raw, b->x, b->mu, b->source, b->exact, b->phi};
  uint8_t *const flags[] = {b->on_boundary, b->condition, b->inside};
  for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++) free(arrays[k]);
  for (size_t k = 0; k < sizeof flags / sizeof *flags; k++) free(flags[k]);
  free(b->order);
}

static double peak_megabytes(void) {
  struct rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return (double)usage.ru_maxrss / 1024;
}

/* Ends a phase that began at *start: keeps the best time. */
static void lap(bench *b, int phase, double *start) {
  const double end = now(), seconds = end - *start;
  if (b->seconds[phase] == 0 || seconds < b->seconds[phase]) b->seconds[phase] = seconds;
  *start = now();
}

/* The cloud renumbered along the space-filling curve. */
static void order(bench *b) {
  const sct_cloud raw = {b->dim, b->n, b->raw};
  sct_error err;
  double start = now();
  check(sct_cloud_order(&raw, b->order, &err), &err);
  for (int64_t k = 0; k < b->n; k++) {
    memcpy(b->x + k * b->dim, b->raw + (int64_t)b->order[k] * b->dim,
           (size_t)b->dim * sizeof *b->x);
  }
  lap(b, PHASE_order, &start);
}

/* -lap phi = dim pi^2 phi, phi = prod sin(pi x), 0 on the boundary. */
static void set_fields(bench *b) {
  for (int64_t k = 0; k < b->n; k++) {
    b->exact[k] = 1;
    for (int a = 0; a < b->dim; a++) b->exact[k] *= sin(pi * b->x[k * b->dim + a]);
    b->mu[k] = 1;
    b->source[k] = b->dim * pi * pi * b->exact[k];
    b->inside[k] = !b->on_boundary[b->order[k]];
    b->condition[k] = b->inside[k] ? SCT_INTERIOR : SCT_DIRICHLET;
    b->phi[k] = 0;
  }
}

static void solve(bench *b, const sct_system *system) {
  const sct_solve_options options = {.dim = b->dim,
                                     .method = b->method,
                                     .preconditioner = b->preconditioner,
                                     .is_equation = system->is_equation};
  sct_solver *solver = NULL;
  sct_error err;
  double *rhs = memory_for(2 * system->unknowns, sizeof *rhs), *unknown = rhs + system->unknowns;
  sct_system_rhs(system, b->phi, rhs);
  if (b->peak_before == 0) b->peak_before = peak_megabytes();
  double start = now();
  check(sct_solver_analyse(system->matrix, &options, &solver, &err), &err);
  check(sct_solver_factor(solver, system->matrix, &err), &err);
  lap(b, PHASE_factor, &start);
  check(sct_solver_solve(solver, rhs, false, unknown, &err), &err);
  lap(b, PHASE_solve, &start);
  for (int64_t row = 0; row < system->unknowns; row++) b->phi[system->point_of[row]] = unknown[row];
  b->l2 = sct_norms_of(b->phi, b->exact, b->n, 1, b->inside).l2;
  b->report = *sct_solver_report(solver);
  sct_solver_free(&solver);
  free(rhs);
}

/* All phases once. */
static void run(bench *b, const sct_operator *op, const sct_work *work, bool with_solve) {
  const sct_cloud cloud = {b->dim, b->n, b->x};
  const sct_fields fields = {.diffusivity = b->mu, .source = b->source};
  const sct_boundary boundary = {.condition = b->condition};
  sct_search *search = NULL;
  sct_stencil *stencil = NULL;
  sct_system *system = NULL;
  sct_error err;
  order(b);
  set_fields(b);
  double start = now();
  check(sct_search_build(&cloud, op->radius * b->spacing, SCT_SEARCH_AUTO, work, &search, &err),
        &err);
  lap(b, PHASE_search, &start);
  check(sct_stencil_build(&cloud, search, b->spacing, op, 1000, work, &stencil, &err), &err);
  lap(b, PHASE_lists, &start);
  check(sct_stencil_apply(stencil, b->exact, work, NULL, NULL, b->phi, &err), &err);
  lap(b, PHASE_apply, &start);
  check(sct_system_build(stencil, &fields, &boundary, work, &system, &err), &err);
  lap(b, PHASE_assemble, &start);
  b->neighbours = sct_stencil_lists(stencil)->start[b->n];
  b->widened = system->widened;
  memset(b->phi, 0, (size_t)b->n * sizeof *b->phi);
  if (with_solve) solve(b, system);
  sct_system_free(&system);
  sct_stencil_free(&stencil);
  sct_search_free(&search);
}

static void print(const bench *b, const sct_operator *op) {
  static const char *const names[] = {
#define PHASE_NAME(name) #name,
      PHASES(PHASE_NAME)
#undef PHASE_NAME
  };
  printf(
      "{\"dim\": %d, \"points\": %lld, \"scheme\": \"%s\", \"degree\": %d, \"neighbours\": %.2f, "
      "\"widened\": %lld, \"l2\": %.3e",
      b->dim, (long long)b->n, sct_scheme_name(op->scheme), op->degree,
      (double)b->neighbours / (double)b->n, (long long)b->widened, b->l2);
  for (int k = 0; k < PHASE_COUNT; k++) printf(", \"%s\": %.6f", names[k], b->seconds[k]);
  const sct_solve_report *r = &b->report;
  if (r->method != NULL) {
    printf(
        ", \"method\": \"%s\", \"krylov\": \"%s\", \"preconditioner\": \"%s\", "
        "\"iterations\": %d, \"residual\": %.2e, \"fallback\": \"%s\"",
        r->method, r->krylov == NULL ? "" : r->krylov,
        r->preconditioner == NULL ? "" : r->preconditioner, r->iterations, r->residual,
        r->fallback);
  }
  printf(", \"peak_before\": %.1f, \"peak\": %.1f}\n", b->peak_before, peak_megabytes());
}

/* Argument k as a number. */
static long long argument(int count, char **arguments, int k, long long otherwise) {
  return count > k ? llround(atof(arguments[k])) : otherwise;
}

int main(int count, char **arguments) {
  const int dim = (int)argument(count, arguments, 1, 2);
  const int64_t points = argument(count, arguments, 2, 100000);
  const sct_work work = {.threads = (int)argument(count, arguments, 3, 1)};
  const long long repeats = argument(count, arguments, 4, 3);
  const bool with_solve = argument(count, arguments, 5, 0);
  const int degree = (int)argument(count, arguments, 7, 2);
  watch = work.threads > 1 ? CLOCK_MONOTONIC : CLOCK_PROCESS_CPUTIME_ID;
  for (int s = SCT_PS; s < SCT_SCHEME_COUNT; s++) {
    sct_operator op = sct_operator_default((sct_scheme)s, degree);
    if (count > 6 && s != (int)sct_scheme_find(arguments[6])) continue;
    if (degree == 2) op.radius = 2.1;
    bench b = bench_new(dim, points);
    b.method = count > 8 ? arguments[8] : NULL;
    b.preconditioner = count > 9 ? arguments[9] : NULL;
    for (long long k = 0; k < repeats; k++) run(&b, &op, &work, with_solve);
    print(&b, &op);
    bench_free(&b);
  }
  return 0;
}
