/* Counters and their text. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "counter.h"

static int tear_down(void **state) {
  (void)state;
  counter_reset();
  return 0;
}

/* Is this a line of the text? */
static bool says(const char *line) {
  size_t size;
  char *text = counter_text(&size), with_ends[512];
  assert_non_null(text);
  assert_int_equal(strlen(text), size);
  snprintf(with_ends, sizeof with_ends, "\n%s\n", line);
  const bool found = strstr(text, with_ends) != NULL;
  if (!found) print_message("%s\n", text);
  free(text);
  return found;
}

static void every_row_has_help_and_type(void **state) {
  (void)state;
  size_t size;
  char *text = counter_text(&size);
  int rows = 0;
  for (const char *at = text; (at = strstr(at, "# TYPE ")) != NULL; at++) rows++;
  assert_int_equal(rows, COUNTER_COUNT);
  free(text);
}

static void counts_add_up_by_labels(void **state) {
  (void)state;
  counter_add(COUNTER_REQUESTS, 1, LABELS("/a", "GET", "200"));
  counter_add(COUNTER_REQUESTS, 2, LABELS("/a", "GET", "404"));
  counter_add(COUNTER_REQUESTS, 1, LABELS("/a", "GET", "200"));
  counter_add(COUNTER_REQUESTS, -5, LABELS("/a", "GET", "200"));
  counter_add(COUNTER_REQUESTS, NAN, LABELS("/a", "GET", "200"));
  assert_true(says("scatterd_http_requests_total{route=\"/a\",method=\"GET\",status=\"200\"} 2"));
  assert_true(says("scatterd_http_requests_total{route=\"/a\",method=\"GET\",status=\"404\"} 2"));
}

static void gauges_are_the_last_value(void **state) {
  (void)state;
  counter_set(COUNTER_QUEUE, 7, NO_LABELS);
  counter_set(COUNTER_QUEUE, 3, NO_LABELS);
  assert_true(says("scatterd_queue_length 3"));
  counter_set(COUNTER_STORE_FREE, 12345678901234, NO_LABELS);
  assert_true(says("scatterd_store_free_bytes 12345678901234"));
  counter_set(COUNTER_QUEUE, NAN, NO_LABELS);
  assert_true(says("scatterd_queue_length NaN"));
  counter_set(COUNTER_QUEUE, -INFINITY, NO_LABELS);
  assert_true(says("scatterd_queue_length -Inf"));
}

static void histograms_are_cumulative(void **state) {
  (void)state;
  counter_observe(COUNTER_RUN_SECONDS, 0.001,
                  LABELS("solve", "run")); /* an end belongs to its bucket */
  counter_observe(COUNTER_RUN_SECONDS, 0.002, LABELS("solve", "run"));
  counter_observe(COUNTER_RUN_SECONDS, 1e6, LABELS("solve", "run"));
  assert_true(says("scatterd_run_seconds_bucket{process=\"solve\",work=\"run\",le=\"0.001\"} 1"));
  assert_true(says("scatterd_run_seconds_bucket{process=\"solve\",work=\"run\",le=\"0.0025\"} 2"));
  assert_true(says("scatterd_run_seconds_bucket{process=\"solve\",work=\"run\",le=\"1800\"} 2"));
  assert_true(says("scatterd_run_seconds_bucket{process=\"solve\",work=\"run\",le=\"+Inf\"} 3"));
  assert_true(says("scatterd_run_seconds_count{process=\"solve\",work=\"run\"} 3"));
  counter_observe(COUNTER_WAIT_SECONDS, 0.5, NO_LABELS);
  assert_true(says("scatterd_queue_wait_seconds_sum 0.5"));
  assert_true(says("scatterd_queue_wait_seconds_bucket{le=\"0.5\"} 1"));
}

static void labels_are_escaped(void **state) {
  (void)state;
  counter_add(COUNTER_BYTES_IN, 1, LABELS("a\"b\\c\nd"));
  assert_true(says("scatterd_http_request_bytes_total{route=\"a\\\"b\\\\c\\nd\"} 1"));
}

static void series_are_bounded(void **state) {
  (void)state;
  char name[32];
  for (int k = 0; k < 10 * COUNTER_SERIES_MAX; k++) {
    snprintf(name, sizeof name, "/%d", k);
    counter_add(COUNTER_BYTES_IN, 1, LABELS(name));
  }
  size_t size;
  char *text = counter_text(&size), line[96];
  int lines = 0;
  for (const char *at = text; (at = strstr(at, "_request_bytes_total{")) != NULL; at++) lines++;
  assert_int_equal(lines, COUNTER_SERIES_MAX);
  free(text);
  snprintf(line, sizeof line, "scatterd_http_request_bytes_total{route=\"other\"} %d",
           9 * COUNTER_SERIES_MAX + 1);
  assert_true(says(line));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_teardown(every_row_has_help_and_type, tear_down),
      cmocka_unit_test_teardown(counts_add_up_by_labels, tear_down),
      cmocka_unit_test_teardown(gauges_are_the_last_value, tear_down),
      cmocka_unit_test_teardown(histograms_are_cumulative, tear_down),
      cmocka_unit_test_teardown(labels_are_escaped, tear_down),
      cmocka_unit_test_teardown(series_are_bounded, tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
