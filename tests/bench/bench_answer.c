/* bench_answer: what a small solve costs inside a worker, and how much of it is not the library.
 *   bench_answer [cells per side ...]      (9 and 19 without argument: 100 and 400 points)
 * The request has posted points, a group, three expressions and all outputs, JSON both ways; the
 * bare library solves the same points with fields at hand. Medians, microseconds.
 */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "answer.h"
#include "doc.h"
#include "scatter/scatter.h"
#include "stopwatch.h"

enum { REPEATS = 301 };

typedef struct {
  int64_t n;
  double *x;
  uint8_t *condition;
  double *value, *diffusivity, *velocity, *source;
  char *body;
} sample;

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void require(bool good, const char *what) {
  if (good) return;
  fprintf(stderr, "bench_answer: %s\n", what);
  exit(1);
}

static int compare(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static double median(double *value) {
  qsort(value, REPEATS, sizeof *value, compare);
  return value[REPEATS / 2];
}

/* u . grad phi = div(mu grad phi) + s, phi = x^2 + y on the boundary. */
static void make_fields(sample *s) {
  for (int64_t i = 0; i < s->n; i++) {
    const double *p = s->x + 2 * i;
    s->condition[i] =
        p[0] == 0 || p[0] == 1 || p[1] == 0 || p[1] == 1 ? SCT_DIRICHLET : SCT_INTERIOR;
    s->value[i] = p[0] * p[0] + p[1];
    s->diffusivity[i] = 0.1;
    s->velocity[2 * i] = 1;
    s->velocity[2 * i + 1] = p[0];
    s->source[i] = 2 * p[0] + p[0] - 0.2;
  }
}

static char *make_body(const sample *s) {
  size_t size = 0;
  char *body = NULL;
  FILE *out = open_memstream(&body, &size);
  fprintf(out, "{\"inputs\":{\"cloud\":{\"points\":[");
  for (int64_t i = 0; i < s->n; i++) {
    fprintf(out, "%s[%.17g,%.17g]", i ? "," : "", s->x[2 * i], s->x[2 * i + 1]);
  }
  fprintf(out, "],\"groups\":{\"wall\":[");
  const char *between = "";
  for (int64_t i = 0; i < s->n; i++) {
    if (!s->condition[i]) continue;
    fprintf(out, "%s%lld", between, (long long)i);
    between = ",";
  }
  fprintf(
      out,
      "]}},\"velocity\":[1,\"x\"],\"diffusivity\":0.1,\"source\":\"2*x+x-0.2\",\"exact\":"
      "\"x^2+y\",\"boundary\":[{\"on\":\"wall\",\"type\":\"dirichlet\",\"value\":\"x^2+y\"}]}}");
  fclose(out);
  return body;
}

static sample make_sample(int64_t cells) {
  const sct_lattice lattice = {2, {0, 0}, {1, 1}, {cells, cells}, 0.3, 7};
  sample s = {.n = sct_lattice_count(&lattice)};
  s.x = calloc((size_t)s.n, 8 * sizeof *s.x);
  s.condition = calloc((size_t)s.n, 1);
  s.value = s.x + 2 * s.n;
  s.diffusivity = s.x + 3 * s.n;
  s.velocity = s.x + 4 * s.n;
  s.source = s.x + 6 * s.n;
  sct_lattice_points(&lattice, s.x);
  make_fields(&s);
  s.body = make_body(&s);
  return s;
}

/* The bare library, points in their order. */
static void solve_bare(const sample *s) {
  const sct_cloud cloud = {2, s->n, s->x};
  const sct_operator op = sct_operator_default(SCT_LSMPS, 2);
  const sct_fields fields = {s->velocity, s->diffusivity, s->source, NULL};
  const sct_boundary boundary = {s->condition, s->value, NULL, NULL};
  const sct_solve_options options = {.dim = 2, .method = "auto"};
  sct_error err = {0};
  sct_search *search = NULL;
  sct_stencil *stencil = NULL;
  sct_system *system = NULL;
  sct_solver *solver = NULL;
  double h, *room = malloc((size_t)s->n * 3 * sizeof *room), *b = room + s->n, *x = b + s->n;
  bool good = !sct_search_build(&cloud, 0, SCT_SEARCH_AUTO, NULL, &search, &err) &&
              !sct_search_nearest(search, NULL, room, &err) && !sct_median(room, s->n, &h, &err) &&
              !sct_stencil_build(&cloud, search, h, &op, 500, NULL, &stencil, &err) &&
              !sct_system_build(stencil, &fields, &boundary, NULL, &system, &err) &&
              !sct_solver_analyse(system->matrix, &options, &solver, &err) &&
              !sct_solver_factor(solver, system->matrix, &err);
  require(good, err.text);
  sct_system_rhs(system, s->value, b);
  require(!sct_solver_solve(solver, b, false, x, &err), err.text);
  sct_solver_free(&solver);
  sct_system_free(&system);
  sct_stencil_free(&stencil);
  sct_search_free(&search);
  free(room);
}

/* Answers, and takes the laps out of the reply. */
static void solve_whole(const sample *s, double seconds[LAP_COUNT + 1]) {
  static const limits most = {.body_bytes = 1 << 28,
                              .decoded_bytes = 1 << 28,
                              .depth = 64,
                              .nodes = 1000000,
                              .points = 2000000,
                              .neighbours = 500,
                              .expression_bytes = 4096,
                              .expression_work = 1000000000,
                              .steps = 1000000,
                              .memory_bytes = INT64_C(1) << 32,
                              .seconds = 60,
                              .threads = 1,
                              .ranks = 1};
  const ask question = {
      .process = "solve", .body = s->body, .size = strlen(s->body), .limits = &most};
  const doc_limits wide = {64, 1000000, 100000000};
  doc_arena *arena = NULL;
  doc_error error;
  reply r;
  double begun = now();
  answer(&question, &r);
  seconds[LAP_COUNT] = now() - begun;
  require(r.status == 200, r.bytes);
  const doc *root = doc_from_json(r.bytes, r.size, &wide, &arena, &error);
  const doc *laps = doc_member(doc_member(doc_member(root, "report"), "value"), "seconds");
  for (int k = 0; k < LAP_COUNT; k++) seconds[k] = doc_member(laps, lap_name((lap)k))->number;
  doc_arena_free(&arena);
  free(r.bytes);
}

static void measure(int64_t cells) {
  static double laps[LAP_COUNT + 2][REPEATS];
  sample s = make_sample(cells);
  for (int r = 0; r < REPEATS; r++) {
    double seconds[LAP_COUNT + 1], begun = now();
    solve_bare(&s);
    laps[LAP_COUNT + 1][r] = now() - begun;
    solve_whole(&s, seconds);
    for (int k = 0; k <= LAP_COUNT; k++) laps[k][r] = seconds[k];
  }
  double whole = median(laps[LAP_COUNT]), bare = median(laps[LAP_COUNT + 1]);
  printf("%5lld points, body %6zu bytes: answer %7.1f, bare library %7.1f, overhead %7.1f;",
         (long long)s.n, strlen(s.body), 1e6 * whole, 1e6 * bare, 1e6 * (whole - bare));
  for (int k = 0; k < LAP_COUNT; k++) printf(" %s %.1f", lap_name((lap)k), 1e6 * median(laps[k]));
  printf("\n");
  free(s.x);
  free(s.condition);
  free(s.body);
}

int main(int count, char **arguments) {
  for (int k = 1; k < count; k++) measure(atoll(arguments[k]));
  if (count < 2) {
    measure(9);
    measure(19);
  }
  return 0;
}
