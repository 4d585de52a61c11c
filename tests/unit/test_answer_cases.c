/* The table of answer_cases.txt: request, status, pointers. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "answer_cases.h"
#include "asking.h"

enum { CASES_LEAST = 60 };

static bool answers_well(const answer_case *c) {
  char found[ANSWER_CASE_LINE];
  asked a = ask_json(c->process, c->body);
  bool is_good = a.raw.status == c->status;
  if (c->status != 200) is_good &= !strcmp(culprits_of(&a, found, sizeof found), c->pointers);
  if (c->status != 200) is_good &= !strcmp(a.raw.type, "application/problem+json");
  if (c->status != 200) is_good &= number_at(a.root, "/status") == c->status;
  if (!is_good) {
    print_error("%sgot %d, needs %d %s: %.*s\n", c->title, a.raw.status, c->status, c->pointers,
                (int)a.raw.size, (char *)a.raw.bytes);
  }
  asked_clear(&a);
  return is_good;
}

static void test_cases(void **state) {
  static answer_case c;
  int count = 0, failed = 0;
  FILE *file = fopen(ANSWER_CASES, "r");
  (void)state;
  assert_non_null(file);
  while (answer_case_next(file, &c)) {
    count++;
    failed += !answers_well(&c);
  }
  fclose(file);
  assert_true(count >= CASES_LEAST);
  assert_int_equal(0, failed);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_cases)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
