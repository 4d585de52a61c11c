/* Numbers in and out of bodies, ns per double, beside cJSON alone and plain copying.
 *
 * usage: bench_codec [numbers]    (1e6 without argument)
 */
#include <cjson/cJSON.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "doc.h"
#include "emit.h"

enum { REPEATS = 5 };

static const doc_limits wide = {.depth = 10, .nodes = 100000000, .numbers = 100000000};

static double seconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* What a run works on. */
typedef struct {
  const double *values;
  int64_t n;
  const char *body; /* for decoders */
  size_t size;
} job;

typedef size_t runner(const job *j);

static size_t emit_as(const job *j, emit_format format, int rank, const int64_t *shape) {
  size_t size;
  emit *e = emit_new(format);
  emit_doubles(e, j->values, rank, shape);
  emit_bytes(e, &size);
  emit_free(&e);
  return size;
}

static size_t print_json(const job *j) {
  return emit_as(j, EMIT_JSON, 1, (int64_t[]){j->n});
}
static size_t print_json_rows(const job *j) {
  return emit_as(j, EMIT_JSON, 2, (int64_t[]){j->n / 2, 2});
}
static size_t print_cbor(const job *j) {
  return emit_as(j, EMIT_CBOR, 1, (int64_t[]){j->n});
}

static size_t print_cjson(const job *j) {
  cJSON *array = cJSON_CreateDoubleArray(j->values, (int)j->n);
  char *text = cJSON_PrintUnformatted(array);
  size_t size = strlen(text);
  cJSON_free(text);
  cJSON_Delete(array);
  return size;
}

static size_t parse_json(const job *j) {
  doc_arena *arena;
  doc_error error;
  const doc *d = doc_from_json(j->body, j->size, &wide, &arena, &error);
  size_t count = d == NULL ? 0 : (size_t)d->count;
  doc_arena_free(&arena);
  return count;
}

static size_t parse_cbor(const job *j) {
  doc_arena *arena;
  doc_error error;
  const doc *d = doc_from_cbor(j->body, j->size, &wide, &arena, &error);
  size_t count = d == NULL ? 0 : (size_t)d->count;
  doc_arena_free(&arena);
  return count;
}

static size_t parse_cjson(const job *j) {
  cJSON *array = cJSON_ParseWithLength(j->body, j->size);
  size_t count = (size_t)cJSON_GetArraySize(array);
  cJSON_Delete(array);
  return count;
}

static size_t parse_strtod(const job *j) {
  size_t count = 0;
  char *p = (char *)(uintptr_t)j->body + 1;
  for (double sum = 0; *p != '\0'; p++, count++) sum += strtod(p, &p);
  return count;
}

/* Best of some runs, so that noise of the machine matters less. */
static double best(runner *run, const job *j) {
  double least = 1e9;
  for (int k = 0; k < REPEATS; k++) {
    double start = seconds();
    size_t result = run(j);
    double took = seconds() - start;
    if (result == 0) fprintf(stderr, "nothing came out\n");
    if (took < least) least = took;
  }
  return 1e9 * least / (double)j->n;
}

static void report(const char *what, double ns, double reference) {
  printf("  %-28s %8.1f ns per double  %6.1f times cJSON's speed\n", what, ns, reference / ns);
}

static char *body_of(const double *values, emit_format format, int rank, const int64_t *shape,
                     size_t *size) {
  emit *e = emit_new(format);
  emit_doubles(e, values, rank, shape);
  const void *bytes = emit_bytes(e, size);
  char *body = malloc(*size + 1);
  if (body == NULL) exit(1);
  memcpy(body, bytes, *size);
  body[*size] = '\0';
  emit_free(&e);
  return body;
}

static void bench(const char *title, const double *values, int64_t n) {
  size_t size, rows_size, cbor_size;
  char *json = body_of(values, EMIT_JSON, 1, (int64_t[]){n}, &size);
  char *rows = body_of(values, EMIT_JSON, 2, (int64_t[]){n / 2, 2}, &rows_size);
  char *cbor = body_of(values, EMIT_CBOR, 1, (int64_t[]){n}, &cbor_size);
  job j = {values, n, json, size}, in_rows = {values, n, rows, rows_size};
  job packed = {values, n, cbor, cbor_size};
  double print = best(print_cjson, &j), parse = best(parse_cjson, &j);
  printf("%s: %lld numbers, %.1f bytes each as JSON\n", title, (long long)n,
         (double)size / (double)n);
  report("print cJSON", print, print);
  report("print JSON", best(print_json, &j), print);
  report("print JSON, rows of 2", best(print_json_rows, &j), print);
  report("print CBOR", best(print_cbor, &j), print);
  report("parse cJSON", parse, parse);
  report("parse strtod", best(parse_strtod, &j), parse);
  report("parse JSON", best(parse_json, &j), parse);
  report("parse JSON, rows of 2", best(parse_json, &in_rows), parse);
  report("parse CBOR", best(parse_cbor, &packed), parse);
  free(json);
  free(rows);
  free(cbor);
}

/* SplitMix64 to [0, 1). */
static double next(uint64_t *state) {
  uint64_t z = *state += 0x9E3779B97F4A7C15u;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

int main(int argc, char **argv) {
  int64_t n = argc > 1 ? (int64_t)atof(argv[1]) : 1000000;
  uint64_t seed = 1;
  double *values = malloc((size_t)n * sizeof *values);
  if (values == NULL || n < 2) return 1;
  for (int64_t k = 0; k < n; k++) values[k] = 2 * next(&seed) - 1;
  bench("random in [-1, 1)", values, n);
  for (int64_t k = 0; k < n; k++) values[k] = (double)(k % 1000) / 1000;
  bench("three decimals", values, n);
  for (int64_t k = 0; k < n; k++) values[k] = (double)k;
  bench("integers", values, n);
  free(values);
  return 0;
}
