/* bench_flow.c - one flow from the command line: how right it is, how long it takes.
 *
 *   bench_flow CASE [name=value ...]      CASE: cavity, step
 *     cells=40 reynolds=100 end=20 scheme=ips walls=points clustering=0 shift=0.25 courant=0.25
 *     jitter=0 seed=0 samples=200 threads=1 downstream=12 dump=FILE
 *
 * Prints one JSON object; `dump` writes particles, mesh and sections as text for a plot.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

#include "scatter/flow_case.h"

static const char *word(int argc, char **argv, const char *name, const char *fallback) {
  const size_t length = strlen(name);
  for (int k = 2; k < argc; k++) {
    if (!strncmp(argv[k], name, length) && argv[k][length] == '=') return argv[k] + length + 1;
  }
  return fallback;
}

static double number(int argc, char **argv, const char *name, double fallback) {
  const char *text = word(argc, argv, name, NULL);
  return text != NULL ? strtod(text, NULL) : fallback;
}

static double cpu_seconds(void) {
  struct rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return (double)(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
         1e-6 * (double)(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

static double wall_seconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void print_array(const char *name, const double *value, int64_t n, const char *end) {
  printf("\"%s\":[", name);
  for (int64_t k = 0; k < n; k++) printf("%s%.8g", k > 0 ? "," : "", value[k]);
  printf("]%s", end);
}

static void print_section(const sct_flow *f, int along, double at, const char *end) {
  const int64_t most = sct_flow_section_most(f, along);
  double *s = calloc((size_t)(2 * most), sizeof *s);
  if (s == NULL) exit(1);
  const int64_t n = sct_flow_section(f, false, along, at, s, s + most);
  printf("{\"at\":%.8g,", at);
  print_array("s", s, n, ",");
  print_array("value", s + most, n, "}");
  printf("%s", end);
  free(s);
}

static void print_history(const sct_flow *f) {
  const sct_flow_sample *h;
  const int64_t n = sct_flow_history(f, &h), width = sizeof *h / sizeof(double);
  static const char *const names[] = {"t",
                                      "circulation",
                                      "particles",
                                      "divergence",
                                      "divergence_before",
                                      "cell_reynolds",
                                      "diffusivity_mean",
                                      "diffusivity_rms",
                                      "empty",
                                      "crowded",
                                      "nearest",
                                      "nearest_1",
                                      "limited",
                                      "speed",
                                      "scalar"};
  double *column = calloc((size_t)n, sizeof *column);
  if (column == NULL) exit(1);
  printf("\"history\":{");
  for (int64_t c = 0; c < width; c++) {
    for (int64_t k = 0; k < n; k++) column[k] = ((const double *)&h[k])[c];
    print_array(names[c], column, n, c + 1 < width ? "," : "},");
  }
  free(column);
}

static void dump(const sct_flow *f, const sct_flow_case *c, const char *path) {
  FILE *out = fopen(path, "w");
  const sct_flow_cloud p = sct_flow_particles(f);
  const int64_t nx = c->domain.cells[0], ny = c->domain.cells[1];
  double *pressure = calloc((size_t)(nx * ny), sizeof(double));
  double *stream = calloc((size_t)((nx + 1) * (ny + 1)), sizeof(double));
  if (out == NULL || pressure == NULL || stream == NULL) exit(1);
  sct_flow_mesh(f, false, pressure, stream, NULL, NULL);
  fprintf(out, "%lld %lld %lld\n", (long long)p.n, (long long)nx, (long long)ny);
  for (int64_t k = 0; k < p.n; k++) {
    fprintf(out, "%.9g %.9g %.9g %.9g\n", p.x[2 * k], p.x[2 * k + 1], p.u[2 * k], p.u[2 * k + 1]);
  }
  for (int64_t k = 0; k <= nx; k++) fprintf(out, "%.9g\n", c->edge[0][k]);
  for (int64_t k = 0; k <= ny; k++) fprintf(out, "%.9g\n", c->edge[1][k]);
  for (int64_t k = 0; k < nx * ny; k++) fprintf(out, "%.9g\n", pressure[k]);
  for (int64_t k = 0; k < (nx + 1) * (ny + 1); k++) fprintf(out, "%.9g\n", stream[k]);
  fclose(out);
  free(pressure);
  free(stream);
}

static int fail(const sct_error *err) {
  char room[1024];
  fprintf(stderr, "bench_flow: %s\n", sct_error_message(err, room, sizeof room));
  return 1;
}

static void print_result(const sct_flow *f, const sct_flow_case *c) {
  const double sections[] = {0.5, 1, 2, 3, 4, 6, 8};
  const sct_flow_vortex v = sct_flow_find_vortex(f, false);
  printf("\"vortex\":{\"x\":%.8g,\"y\":%.8g,\"circulation\":%.8g},", v.x, v.y, v.circulation);
  if (c->step_height > 0) {
    const double x = sct_flow_reattachment(f, false, 0, 0) / c->step_height;
    printf("\"step_height\":%.8g,", c->step_height);
    if (isfinite(x)) printf("\"reattachment\":%.8g,", x);
  }
  printf("\"u\":[");
  if (c->step_height > 0) {
    for (int k = 0; k < 7; k++) {
      print_section(f, 0, sections[k] * c->step_height, k < 6 ? "," : "],\"v\":[],");
    }
  } else {
    print_section(f, 0, 0.5, "],\"v\":[");
    print_section(f, 1, 0.5, "],");
  }
  print_history(f);
}

int main(int argc, char **argv) {
  sct_error err = {0};
  sct_flow_case c;
  sct_flow *f = NULL;
  const bool step = argc > 1 && !strcmp(argv[1], "step");
  const int64_t cells = (int64_t)number(argc, argv, "cells", step ? 17 : 40);
  const double reynolds = number(argc, argv, "reynolds", 100);
  const double end = number(argc, argv, "end", step ? 60 : 20);
  const double clustering = number(argc, argv, "clustering", 0);
  const sct_scheme scheme = sct_scheme_find(word(argc, argv, "scheme", "ips"));
  const sct_work work = {.threads = (int)number(argc, argv, "threads", 1)};
  const double down = number(argc, argv, "downstream", 12);
  if (argc < 2 || (step ? sct_flow_step(cells, reynolds, clustering, down, scheme, end, &c, &err)
                        : sct_flow_cavity(cells, reynolds, clustering, scheme, end, &c, &err))) {
    return fail(&err);
  }
  c.options.shift = number(argc, argv, "shift", c.options.shift);
  c.options.courant = number(argc, argv, "courant", c.options.courant);
  c.options.jitter = number(argc, argv, "jitter", 0);
  c.options.samples = (int64_t)number(argc, argv, "samples", 200);
  c.options.seed = (uint64_t)number(argc, argv, "seed", 0);
  if (!strcmp(word(argc, argv, "walls", "points"), "mirror"))
    c.options.walls = SCT_FLOW_WALL_MIRROR;
  double seconds = wall_seconds(), cpu = cpu_seconds();
  if (sct_flow_build(&c.domain, &c.options, &f, &err)) return fail(&err);
  if (sct_flow_advance(f, INT64_MAX, &work, &err)) return fail(&err);
  seconds = wall_seconds() - seconds;
  cpu = cpu_seconds() - cpu;
  const sct_flow_report r = sct_flow_reports(f);
  const sct_flow_sample *h;
  const int64_t n = sct_flow_history(f, &h);
  double updates = 0;
  for (int64_t k = 0; k < n; k++) updates += h[k].particles / (double)n * (double)r.steps;
  printf(
      "{\"seconds\":%.3f,\"cpu\":%.3f,\"microseconds_per_particle_step\":%.4f,\"steps\":%lld,"
      "\"particles\":%lld,\"cells\":%lld,\"inserted\":%lld,\"removed\":%lld,"
      "\"circulation_sd\":%.3g,",
      seconds, cpu, 1e6 * cpu / updates, (long long)r.steps, (long long)r.particles,
      (long long)r.cells, (long long)r.inserted, (long long)r.removed, r.circulation_deviation);
  print_result(f, &c);
  printf("\"scheme\":\"%s\"}\n", sct_scheme_name(scheme));
  if (word(argc, argv, "dump", NULL) != NULL) dump(f, &c, word(argc, argv, "dump", NULL));
  sct_flow_free(&f);
  sct_flow_case_clear(&c);
  return 0;
}
