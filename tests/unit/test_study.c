/* unit.study: what cannot be seen from outside: what a study tells while it works, and that it
 * stops when told to. The rest is http.study. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "asking.h"

/* What was told: how often, the last text and fraction; says no from call number `stop` on. */
typedef struct {
  int calls, stop, rows;
  char row[64];
  double fraction;
  bool is_ascending;
} listener;

static bool listen(void *context, const char *phase, double fraction) {
  listener *l = context;
  const char *row = strstr(phase, "row ");
  if (row && strcmp(row, l->row)) {
    l->rows++;
    snprintf(l->row, sizeof l->row, "%s", row);
  }
  if (row) {
    l->is_ascending &= fraction >= l->fraction;
    l->fraction = fraction;
  }
  return ++l->calls != l->stop;
}

static reply ask_study(const char *body, listener *l) {
  const limits most = asking_limits();
  const ask question = {.process = "study",
                        .body = body,
                        .size = strlen(body),
                        .limits = &most,
                        .calls = {.report = listen, .context = l}};
  reply r;
  answer(&question, &r);
  return r;
}

static const char body[] =
    "{\"inputs\":{\"case\":\"sine-1d\",\"cells\":[8,16,32],\"parameters\":{\"seeds\":2}}}";

static void test_progress(void **state) {
  listener l = {.is_ascending = true};
  reply r = ask_study(body, &l);
  (void)state;
  assert_int_equal(r.status, 200);
  assert_int_equal(l.rows, 3);
  assert_string_equal(l.row, "row 3 of 3");
  assert_true(l.is_ascending);
  assert_true(l.fraction > 0.8 && l.fraction < 0.84); /* 5 of 6 clouds were done */
  free(r.bytes);
}

static void test_cancel(void **state) {
  listener all = {0};
  reply whole = ask_study(body, &all);
  (void)state;
  free(whole.bytes);
  for (int stop = 1; stop <= all.calls; stop++) {
    listener l = {.stop = stop};
    reply r = ask_study(body, &l);
    assert_int_equal(r.status, 503);
    assert_int_equal(l.calls, stop);
    free(r.bytes);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_progress),
                                     cmocka_unit_test(test_cancel)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
