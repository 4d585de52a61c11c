/* The table of answer_cases.txt: request, status, pointers. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "asking.h"

enum { LINE = 4096, BODY = 1 << 16, CASES_LEAST = 60 };

typedef struct {
  char title[LINE], process[64], pointers[LINE], body[BODY];
  int status;
} a_case;

/* Reads the next case; false at the end of the file. */
static bool next_case(FILE *file, a_case *c) {
  char line[LINE];
  c->title[0] = c->body[0] = '\0';
  while (fgets(line, sizeof line, file)) {
    if (line[0] == '#') snprintf(c->title, sizeof c->title, "%s", line + 2);
    if (line[0] != '#' && line[0] != '\n') break;
  }
  if (feof(file)) return false;
  int used = 0;
  assert_int_equal(2, sscanf(line, "%63s %d %n", c->process, &c->status, &used));
  snprintf(c->pointers, sizeof c->pointers, "%s", line + used);
  c->pointers[strcspn(c->pointers, "\n")] = '\0';
  while (fgets(line, sizeof line, file) && line[0] != '\n') {
    strncat(c->body, line, BODY - strlen(c->body) - 1);
  }
  return true;
}

static bool answers_well(const a_case *c) {
  char found[LINE];
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
  static a_case c;
  int count = 0, failed = 0;
  FILE *file = fopen(ANSWER_CASES, "r");
  (void)state;
  assert_non_null(file);
  while (next_case(file, &c)) {
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
