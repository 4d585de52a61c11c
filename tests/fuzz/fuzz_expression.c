/* Any text as an expression (the first byte is the dimension): understood or refused with a place;
 * what is understood has one value wherever and however it is evaluated, and a slope or none. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cloud_input.h"
#include "expression_slope.h"
#include "fuzz.h"

enum { POINTS = 300, SLOPES = 5, LONGEST = 1024 };

static void require(int holds, const char *what, const char *text) {
  if (holds) return;
  fprintf(stderr, "does not hold: %s: %s\n", what, text);
  abort();
}

/* Points that are in no way round, 0 and negative ones among them. */
static void place_points(double *x, int count) {
  for (int k = 0; k < count; k++) x[k] = k % 7 == 0 ? 0 : 0.37 * (k - count / 3);
}

static int is_same(double a, double b) {
  return memcmp(&a, &b, sizeof a) == 0 || (a != a && b != b);
}

/* In bulk and one by one, through an index and without. */
static void evaluate(task *t, const expression *e, int dim, const double *x) {
  double bulk[POINTS], single;
  language *l = language_of(t);
  require(expression_evaluate(l, e, dim, x, NULL, POINTS, 0.25, bulk, 1), "in bulk", e->text);
  for (int32_t k = 0; k < POINTS; k += 29) {
    require(expression_evaluate(l, e, dim, x, &k, 1, 0.25, &single, 1), "one by one", e->text);
    require(is_same(single, bulk[k]), "one value at one point", e->text);
  }
}

/* Its slope by the parameter a: finite numbers, or the error that says where there is none. */
static void differentiate(task *t, const expression *e, int dim, double *x) {
  double slope[SLOPES];
  int32_t order[SLOPES] = {0, 1, 2, 3, 4};
  cloud_input cloud = {.order = order};
  cloud.cloud = (sct_cloud){.dim = dim, .n = SLOPES, .x = x};
  const sites on = sites_all(&cloud);
  const bool done = expression_slope(t, e, &on, 0.25, "a", 0.5, slope);
  require(done || t->error.code == SCT_E_NOT_FINITE, "a slope, or the reason", e->text);
  for (int k = 0; done && k < SLOPES; k++) require(slope[k] - slope[k] == 0, "finite", e->text);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  doc k = {.kind = DOC_NUMBER, .key = "k", .number = -2};
  doc a = {.kind = DOC_NUMBER, .key = "a", .number = 0.5, .next = &k};
  const doc parameters = {.kind = DOC_OBJECT, .child = &a, .count = 2};
  task t = {.parameters = &parameters, .work.threads = 1};
  double x[POINTS * SCT_DIM_MAX];
  char text[LONGEST + 1] = "";
  expression e;
  expression_error why = {0};
  if (size == 0 || size > LONGEST) return 0;
  const int dim = 1 + data[0] % SCT_DIM_MAX;
  memcpy(text, data + 1, size - 1);
  place_points(x, POINTS * dim);
  t.arena = doc_arena_new();
  if (expression_check(language_of(&t), text, dim, &e, &why)) {
    evaluate(&t, &e, dim, x);
    differentiate(&t, &e, dim, x);
  } else {
    require(why.text[0] != '\0' && why.position >= 0, "a reason", text);
    require(why.position <= (int64_t)strlen(text) + 1, "a place", text);
  }
  language_free(&t.language);
  doc_arena_free(&t.arena);
  return 0;
}
