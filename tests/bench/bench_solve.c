/* bench_solve FILE DIM METHOD...: analyses, factors and solves the system of FILE (written by
 * cloud_matrix.py) with each method, best of several runs, one line of JSON each. */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <time.h>

#include "scatter/solve.h"

typedef struct {
  sct_csr *a;
  double *b, *x;
} linear_system;

typedef struct {
  double first, again, solve, transposed; /* seconds: analyse + factor, factor, solve, A^T */
} timing;

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void need(bool ok, const char *what) {
  if (ok) return;
  fprintf(stderr, "bench_solve: %s\n", what);
  exit(1);
}

static void take(void *out, size_t size, int64_t count, FILE *f) {
  need(fread(out, size, (size_t)count, f) == (size_t)count, "file is short");
}

static linear_system read_system(const char *path) {
  linear_system s = {0};
  int64_t head[2];
  FILE *f = fopen(path, "rb");
  need(f != NULL, path);
  take(head, sizeof *head, 2, f);
  need(sct_csr_new(head[0], head[0], head[1], &s.a, NULL) == SCT_OK, "no memory");
  take(s.a->start, sizeof *s.a->start, head[0] + 1, f);
  take(s.a->column, sizeof *s.a->column, head[1], f);
  take(s.a->value, sizeof *s.a->value, head[1], f);
  s.b = malloc((size_t)head[0] * sizeof *s.b);
  s.x = malloc((size_t)head[0] * sizeof *s.x);
  need(s.b != NULL && s.x != NULL, "no memory");
  take(s.b, sizeof *s.b, head[0], f);
  fclose(f);
  return s;
}

static void least(double *best, double seconds) {
  *best = *best == 0 ? seconds : fmin(*best, seconds);
}

/* One round; returns the solver, with its report. */
static sct_solver *round_of(const linear_system *s, const sct_solve_options *o, timing *best) {
  sct_error err;
  sct_solver *solver = NULL;
  double t[5];
  t[0] = now();
  sct_status status = sct_solver_analyse(s->a, o, &solver, &err);
  if (status == SCT_OK) status = sct_solver_factor(solver, s->a, &err);
  t[1] = now();
  if (status == SCT_OK) status = sct_solver_factor(solver, s->a, &err);
  t[2] = now();
  if (status == SCT_OK) status = sct_solver_solve(solver, s->b, true, s->x, &err);
  t[3] = now();
  if (status == SCT_OK) status = sct_solver_solve(solver, s->b, false, s->x, &err);
  t[4] = now();
  need(status == SCT_OK, err.text);
  least(&best->first, t[1] - t[0]);
  least(&best->again, t[2] - t[1]);
  least(&best->transposed, t[3] - t[2]);
  least(&best->solve, t[4] - t[3]);
  return solver;
}

static void bench(const linear_system *s, int dim, const char *method) {
  const sct_solve_options o = {.dim = dim, .method = method};
  timing best = {0};
  struct rusage usage;
  const double begin = now();
  for (int k = 0; k < 3 || (now() - begin < 1 && k < 200); k++) {
    sct_solver *solver = round_of(s, &o, &best);
    if (k == 0) {
      const sct_solve_report *r = sct_solver_report(solver);
      getrusage(RUSAGE_SELF, &usage);
      printf("{\"method\": \"%s\", \"ordering\": \"%s\", \"rows\": %" PRId64
             ", \"nonzeros\": %" PRId64 ", \"factor_nonzeros\": %" PRId64
             ", \"megabytes\": %.1f, \"resident_megabytes\": %.1f, \"condition\": %.3e, "
             "\"residual\": %.2e",
             r->method, r->ordering, r->rows, r->nonzeros, r->factor_nonzeros,
             (double)r->peak_bytes / 1e6, (double)usage.ru_maxrss / 1e3,
             1 / r->reciprocal_condition, r->residual);
    }
    sct_solver_free(&solver);
  }
  printf(", \"analyse_factor\": %.6f, \"factor\": %.6f, \"solve\": %.6f, \"transposed\": %.6f}\n",
         best.first, best.again, best.solve, best.transposed);
}

int main(int count, char **arguments) {
  need(count > 3, "usage: bench_solve FILE DIM METHOD...");
  linear_system s = read_system(arguments[1]);
  for (int k = 3; k < count; k++) bench(&s, atoi(arguments[2]), arguments[k]);
  sct_csr_free(&s.a);
  free(s.b);
  free(s.x);
  return 0;
}
