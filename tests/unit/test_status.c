/* unit.status: names, messages, lists of points. */
#include <stdio.h>
#include <string.h>

#include "fixture.h"

static void every_code_has_a_name_and_a_text(void **state) {
  (void)state;
  for (int code = 0; code < SCT_STATUS_COUNT; code++) {
    assert_true(strlen(sct_status_name((sct_status)code)) > 1);
    assert_true(strlen(sct_status_text((sct_status)code)) > 1);
    for (int other = 0; other < code; other++) {
      assert_string_not_equal(sct_status_name((sct_status)code),
                              sct_status_name((sct_status)other));
    }
  }
  assert_string_equal(sct_status_name((sct_status)-1), "unknown");
  assert_string_equal(sct_status_name(SCT_STATUS_COUNT), "unknown");
}

static void a_message_names_its_points(void **state) {
  (void)state;
  sct_error err;
  char room[200], small[10];
  assert_int_equal(sct_fail(&err, SCT_E_DEFICIENT, 17, "has %d neighbours, needs %d", 4, 6),
                   SCT_E_DEFICIENT);
  assert_string_equal(sct_error_message(&err, room, sizeof room),
                      "point 17 has 4 neighbours, needs 6");
  for (int64_t k = 18; k < 21; k++) sct_error_add_point(&err, k);
  assert_string_equal(sct_error_message(&err, room, sizeof room),
                      "point 17 has 4 neighbours, needs 6 (and 3 more points: 18, 19, 20)");
  assert_string_equal(sct_error_message(&err, small, sizeof small), "point 17 ");
  sct_fail(&err, SCT_E_ARGUMENT, -1, "radius is %g", 0.5);
  assert_string_equal(sct_error_message(&err, room, sizeof room), "radius is 0.5");
}

static void lists_are_cut_but_counted(void **state) {
  (void)state;
  sct_error a = {.code = SCT_OK}, b;
  char room[400];
  sct_fail(&b, SCT_E_DEFICIENT, 0, "is alone");
  for (int64_t k = 1; k < 30; k++) sct_error_add_point(&b, k);
  sct_error_merge(&a, &b);
  assert_int_equal(a.count, 30);
  sct_error_merge(&a, &b);
  assert_int_equal(a.count, 60);
  assert_int_equal(a.points[SCT_ERROR_POINTS - 1], SCT_ERROR_POINTS - 1);
  assert_non_null(strstr(sct_error_message(&a, room, sizeof room), "and 59 more points: 1, 2, "));
  assert_non_null(strstr(room, ", ...)"));
  sct_error_merge(NULL, &b);
  sct_error_add_point(NULL, 1);
  assert_int_equal(sct_fail(NULL, SCT_E_MEMORY, -1, "nobody listens"), SCT_E_MEMORY);
}

static bool refuse(void *context, const char *phase, double fraction) {
  (void)phase;
  *(double *)context = fraction;
  return false;
}

static void work_may_be_refused(void **state) {
  (void)state;
  double seen = 0;
  sct_error err;
  const sct_work work = {.threads = 3, .report = refuse, .context = &seen};
  assert_int_equal(sct_work_report(&work, "march", 0.25, &err), SCT_E_CANCELLED);
  assert_true(seen == 0.25);
  assert_int_equal(sct_work_report(NULL, "march", 0.25, &err), SCT_OK);
  assert_int_equal(sct_work_threads(&work), 3);
  assert_int_equal(sct_work_threads(NULL), 1);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_code_has_a_name_and_a_text),
      cmocka_unit_test(a_message_names_its_points),
      cmocka_unit_test(lists_are_cut_but_counted),
      cmocka_unit_test(work_may_be_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
