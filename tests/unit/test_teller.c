/* Which reports become news: the first of a phase, later ones after a pause, with the residual
 * heard since the last. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "teller.h"

static void test_phases_begin_at_once(void **state) {
  (void)state;
  teller t = {.pause = 1e6, .last = teller_now()};
  ipc_news news;
  assert_true(teller_takes(&t, "search", 0.25, &news));
  assert_int_equal(news.kind, IPC_PROGRESS);
  assert_string_equal(news.phase, "search");
  assert_true(news.fraction == 0.25 && news.time == t.last && news.residual == 0);
  assert_false(teller_takes(&t, "search", 0.5, &news));
  assert_true(teller_takes(&t, "solve", 0.5, &news));
}

static void test_a_pause_passes(void **state) {
  (void)state;
  teller t = {.pause = 1000, .last = teller_now()};
  ipc_news news;
  assert_true(teller_takes(&t, "solve", 0, &news));
  assert_false(teller_takes(&t, "solve", 0.5, &news));
  t.last -= 1000; /* as if that long ago */
  assert_true(teller_takes(&t, "solve", 0.5, &news));
}

static void test_residuals_wait_for_news(void **state) {
  (void)state;
  teller t = {.pause = 1e6, .last = teller_now()};
  ipc_news news;
  assert_true(teller_takes(&t, "solve", 0, &news));
  t.residual = 0.125;
  assert_false(teller_takes(&t, "solve", 0.5, &news));
  assert_true(t.residual == 0.125);
  assert_true(teller_takes(&t, "encode", 1, &news));
  assert_true(news.residual == 0.125 && t.residual == 0);
}

static void test_long_names_are_cut(void **state) {
  (void)state;
  teller t = {.pause = 1e6, .last = teller_now()};
  ipc_news news;
  char name[2 * sizeof news.phase];
  memset(name, 'x', sizeof name - 1);
  name[sizeof name - 1] = '\0';
  assert_true(teller_takes(&t, name, 0, &news));
  assert_int_equal(strlen(news.phase), sizeof news.phase - 1);
  assert_false(teller_takes(&t, name, 0, &news));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_phases_begin_at_once),
      cmocka_unit_test(test_a_pause_passes),
      cmocka_unit_test(test_residuals_wait_for_news),
      cmocka_unit_test(test_long_names_are_cut),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
