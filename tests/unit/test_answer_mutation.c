/* Requests with one value exchanged for an odd one, in JSON and CBOR: the answer is a result or a
 * problem that blames the request, never a failure. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "answer_cases.h"
#include "asking.h"
#include "emit.h"
#include "seed.h"

enum { MUTATIONS = 10000, SEEDS_MAX = 200 };

/* Odd values as JSON; numbers also take the place of one entry of an array. */
static const char *const odd[] = {"null",
                                  "true",
                                  "\"\"",
                                  "\"x\"",
                                  "\"1/0\"",
                                  "\"t\"",
                                  "\"z\"",
                                  "[]",
                                  "{}",
                                  "[[]]",
                                  "[{}]",
                                  "[1]",
                                  "[1,2]",
                                  "[[1,2],[3,4]]",
                                  "[[[1]]]",
                                  "[1,\"y\"]",
                                  "{\"value\":1}",
                                  "{\"value\":{}}",
                                  "{\"points\":[[0],[1]]}",
                                  "\"boundary\"",
                                  "\"left\"",
                                  "\"interior\"",
                                  "0",
                                  "-0",
                                  "-1",
                                  "1",
                                  "2",
                                  "3",
                                  "0.5",
                                  "7",
                                  "1e-300",
                                  "1e300",
                                  "-1e300",
                                  "4.9e-324",
                                  "2147483647",
                                  "4294967296",
                                  "9007199254740993",
                                  "1e10",
                                  "NaN",
                                  "Infinity"};
enum { ODD = sizeof odd / sizeof *odd };

/* Values of a document: an array of numbers counts as itself and its entries. */
static int64_t count_values(const doc *d) {
  int64_t count = d->kind == DOC_NUMBERS ? 1 + d->count : 1;
  for (const doc *m = d->kind == DOC_NUMBERS ? NULL : d->child; m; m = m->next) {
    count += count_values(m);
  }
  return count;
}

static void emit_entry_changed(emit *e, const doc *d, int64_t k, double value) {
  double *data = malloc((size_t)d->count * sizeof *data);
  memcpy(data, d->data, (size_t)d->count * sizeof *data);
  data[k] = value;
  emit_doubles(e, data, d->rank, d->shape);
  free(data);
}

/* Emits `d` with value number *left in it exchanged for `other`. */
static void emit_changed(emit *e, const doc *d, const doc *other, int64_t *left) {
  int64_t here = (*left)--;
  if (here == 0) {
    emit_doc(e, other);
  } else if (d->kind == DOC_NUMBERS && here > 0 && here <= d->count) {
    emit_entry_changed(e, d, here - 1, other->kind == DOC_NUMBER ? other->number : NAN);
    *left = -1;
  } else if (d->kind == DOC_OBJECT || d->kind == DOC_LIST) {
    if (d->kind == DOC_OBJECT) emit_object(e);
    if (d->kind == DOC_LIST) emit_list(e);
    for (const doc *m = d->child; m; m = m->next) {
      if (m->key) emit_key(e, m->key);
      emit_changed(e, m, other, left);
    }
    emit_end(e);
  } else {
    if (d->kind == DOC_NUMBERS) *left -= d->count;
    emit_doc(e, d);
  }
}

typedef struct {
  char process[64];
  const doc *root;
  doc_arena *arena;
  int64_t values;
} seed_request;

static const doc *parse(const char *json, doc_arena **arena) {
  const doc_limits most = {32, 100000, 100000};
  doc_error error;
  return doc_from_json(json, strlen(json), &most, arena, &error);
}

/* The cases that are answered, or could be but for the numerics. */
static int read_seeds(seed_request *seeds) {
  static answer_case c;
  int count = 0;
  FILE *file = fopen(ANSWER_CASES, "r");
  assert_non_null(file);
  while (count < SEEDS_MAX && answer_case_next(file, &c)) {
    seed_request *s = &seeds[count];
    if (c.status == 400 || c.status == 404) continue;
    s->root = parse(c.body, &s->arena);
    assert_non_null(s->root);
    strcpy(s->process, c.process);
    s->values = count_values(s->root);
    count++;
  }
  fclose(file);
  return count;
}

/* Small limits, so that odd numbers do not make long tests. */
static limits narrow(void) {
  limits most = asking_limits();
  most.points = 2000;
  most.steps = 500;
  return most;
}

/* Nobody waits for a pause. */
static bool impatient(void *context, const char *phase, double fraction) {
  (void)context;
  (void)fraction;
  return strcmp(phase, "pause") != 0;
}

static int answer_changed(const seed_request *s, media form, uint64_t *r) {
  const limits most = narrow();
  int64_t left = (int64_t)(seed_next(r) % (uint64_t)s->values);
  const char *value = odd[seed_below(r, ODD)];
  doc_arena *arena;
  const doc *other = parse(value, &arena);
  emit *e = emit_new(form == MEDIA_CBOR ? EMIT_CBOR : EMIT_JSON);
  emit_changed(e, s->root, other, &left);
  size_t size = 0;
  const void *bytes = emit_bytes(e, &size);
  const ask question = {.process = s->process,
                        .body = bytes,
                        .size = size,
                        .content = form,
                        .accept = media_wish(form),
                        .limits = &most,
                        .calls = {.report = impatient}};
  asked a = ask_all(&question);
  int status = a.raw.status;
  bool is_fine = status == 200 || (status >= 400 && status < 500) || status == 503;
  if (!is_fine) fail_msg("%d for %s in %.*s", status, value, (int)size, (const char *)bytes);
  asked_clear(&a);
  emit_free(&e);
  doc_arena_free(&arena);
  return status;
}

static void test_mutations(void **state) {
  static seed_request seeds[SEEDS_MAX];
  int count = read_seeds(seeds), good = 0, bad = 0;
  uint64_t r = seed_new("unit.answer.mutation");
  (void)state;
  assert_true(count > 15);
  for (int k = 0; k < MUTATIONS; k++) {
    int status = answer_changed(&seeds[seed_below(&r, count)], k % 2 ? MEDIA_CBOR : MEDIA_JSON, &r);
    good += status == 200;
    bad += status == 400;
  }
  printf("%d results, %d bad requests of %d\n", good, bad, MUTATIONS);
  assert_true(good > MUTATIONS / 20 && bad > MUTATIONS / 4);
  for (int k = 0; k < count; k++) doc_arena_free(&seeds[k].arena);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_mutations)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
