/* log.h: one line per event, whatever a client sends. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "log.h"

/* What the calls of `write_line` put on standard error. */
static char *captured(void (*write_line)(void)) {
  static char text[4096];
  int ends[2];
  assert_int_equal(pipe(ends), 0);
  const int saved = dup(STDERR_FILENO);
  dup2(ends[1], STDERR_FILENO);
  write_line();
  dup2(saved, STDERR_FILENO);
  close(saved);
  close(ends[1]);
  const ssize_t size = read(ends[0], text, sizeof text - 1);
  close(ends[0]);
  text[size] = '\0';
  return text;
}

static void plain(void) {
  log_line line;
  log_begin(&line, LOG_INFO, "request");
  log_text(&line, "a", "b/c");
  log_text(&line, "none", NULL);
  log_text(&line, "empty", "");
  log_count(&line, "n", -7);
  log_milliseconds(&line, "ms", 0.0015);
  log_end(&line);
}

static void hostile(void) {
  log_line line;
  log_begin(&line, LOG_INFO, "request");
  log_text(&line, "a", "x\n\"y\" \\ \x1b[2J\xff=");
  log_end(&line);
}

static void endless(void) {
  static char text[100000];
  memset(text, '\n', sizeof text - 1);
  log_line line;
  log_begin(&line, LOG_INFO, "request");
  for (int k = 0; k < 10; k++) log_text(&line, "a", text);
  for (int k = 0; k < 1000; k++) log_count(&line, "n", k);
  log_end(&line);
}

static void unwanted(void) {
  log_limit(LOG_ERROR);
  plain();
  log_say(LOG_DEBUG, "x", "y");
  log_say(LOG_ERROR, "x", "%d %s", 1, "y");
  log_limit(LOG_INFO);
}

static void test_line(void **state) {
  (void)state;
  const char *text = captured(plain);
  assert_memory_equal(text, "time=20", 7);
  assert_string_equal(strstr(text, "Z "),
                      "Z level=info event=request a=b/c empty=\"\" n=-7 ms=1.500\n");
}

static void test_nothing_can_be_forged(void **state) {
  (void)state;
  const char *text = captured(hostile);
  assert_string_equal(strstr(text, " a="), " a=\"x\\x0a\\\"y\\\" \\\\ \\x1b[2J\\xff=\"\n");
}

static void test_long_lines_are_one_line(void **state) {
  (void)state;
  const char *text = captured(endless);
  assert_true(strlen(text) < 2049);
  assert_ptr_equal(strchr(text, '\n'), text + strlen(text) - 1);
}

static void test_levels(void **state) {
  (void)state;
  assert_string_equal(strstr(captured(unwanted), "level="),
                      "level=error event=x message=\"1 y\"\n");
  for (int k = LOG_ERROR; k <= LOG_DEBUG; k++) {
    assert_int_equal(log_level_of(log_level_name((log_level)k)), k);
  }
  assert_int_equal(log_level_of("loud"), -1);
}

/* Nobody reads it: it goes on without, and says afterwards what is lost. */
static void test_nobody_reads(void **state) {
  enum { LINES = 2000 };
  static char text[1 << 20];
  int ends[2];
  (void)state;
  assert_int_equal(pipe(ends), 0);
  const int saved = dup(STDERR_FILENO);
  dup2(ends[1], STDERR_FILENO);
  close(ends[1]);
  alarm(100); /* else it would stand still for ever */
  for (int k = 0; k < LINES; k++) log_say(LOG_ERROR, "x", "%0100d", k);
  alarm(0);
  const ssize_t first = read(ends[0], text, sizeof text - 1);
  log_say(LOG_ERROR, "x", "after it");
  dup2(saved, STDERR_FILENO);
  close(saved);
  assert_true(first > 0);
  int lines = 0;
  for (ssize_t k = 0; k < first; k++) lines += text[k] == '\n';
  assert_int_equal(text[first - 1], '\n');
  const ssize_t second = read(ends[0], text, sizeof text - 1);
  close(ends[0]);
  assert_true(second > 0);
  text[second] = '\0';
  char said[64];
  snprintf(said, sizeof said, " event=log lost=%d\n", LINES - lines);
  assert_non_null(strstr(text, said));
  assert_non_null(strstr(text, "after it"));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_line),
      cmocka_unit_test(test_nothing_can_be_forged),
      cmocka_unit_test(test_long_lines_are_one_line),
      cmocka_unit_test(test_levels),
      cmocka_unit_test(test_nobody_reads),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
