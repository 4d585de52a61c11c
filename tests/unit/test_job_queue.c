/* job_queue.h: priority, turns between submitters, jobs that do not fit. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <stdio.h>

#include "job_queue.h"
#include "seed.h"

typedef struct {
  queue_node node;
  char name[16];
  int size;
} entry;

static bool always(void *context, void *owner) {
  (void)context, (void)owner;
  return true;
}

static bool fits(void *context, void *owner) {
  return ((entry *)owner)->size <= *(int *)context;
}

static void add(job_queue *q, entry *e, const char *name, const char *submitter, int priority) {
  *e = (entry){.size = 1};
  snprintf(e->name, sizeof e->name, "%s", name);
  job_queue_add(q, &e->node, e, submitter, priority, false);
}

static void expect(job_queue *q, const char *name) {
  entry *e = job_queue_take(q, always, NULL);
  assert_non_null(e);
  assert_string_equal(e->name, name);
}

static void test_order_of_one(void **state) {
  job_queue *q = job_queue_new();
  entry e[3];
  (void)state;
  assert_null(job_queue_take(q, always, NULL));
  add(q, &e[0], "1", "a", 5);
  add(q, &e[1], "2", "a", 5);
  add(q, &e[2], "3", "a", 5);
  assert_int_equal(job_queue_length(q), 3);
  expect(q, "1");
  job_queue_add(q, &e[0].node, &e[0], "a", 5, true); /* again, before the others */
  expect(q, "1");
  expect(q, "2");
  expect(q, "3");
  assert_null(job_queue_take(q, always, NULL));
  job_queue_free(&q);
}

static void test_priority(void **state) {
  job_queue *q = job_queue_new();
  entry e[3];
  (void)state;
  add(q, &e[0], "low", "a", 0);
  add(q, &e[1], "usual", "a", 5);
  add(q, &e[2], "high", "b", 9);
  expect(q, "high");
  expect(q, "usual");
  expect(q, "low");
  job_queue_free(&q);
}

/* A thousand jobs of one submitter and three of others: none of the three waits for more than one
 * job of each other submitter. */
static void test_turns(void **state) {
  job_queue *q = job_queue_new();
  entry *many = calloc(1000, sizeof *many), few[3];
  (void)state;
  for (int k = 0; k < 1000; k++) add(q, &many[k], "many", "a", 5);
  add(q, &few[0], "b1", "b", 5);
  add(q, &few[1], "b2", "b", 5);
  add(q, &few[2], "c1", "c", 5);
  expect(q, "many");
  expect(q, "b1");
  expect(q, "c1");
  expect(q, "many");
  expect(q, "b2");
  expect(q, "many");
  job_queue_free(&q);
  free(many);
}

static void test_remove(void **state) {
  job_queue *q = job_queue_new();
  entry e[3];
  (void)state;
  add(q, &e[0], "1", "a", 5);
  add(q, &e[1], "2", "a", 5);
  add(q, &e[2], "3", "b", 5);
  job_queue_remove(q, &e[1].node);
  job_queue_remove(q, &e[1].node); /* no longer there */
  job_queue_remove(q, &e[2].node);
  assert_int_equal(job_queue_length(q), 1);
  expect(q, "1");
  assert_int_equal(job_queue_length(q), 0);
  job_queue_free(&q);
}

/* What does not fit lets others pass, JOB_PATIENCE times; then all wait for it. */
static void test_fit(void **state) {
  job_queue *q = job_queue_new();
  entry large, *small = calloc(100, sizeof *small);
  int room = 1;
  (void)state;
  add(q, &large, "large", "a", 5);
  large.size = 2;
  for (int k = 0; k < 100; k++) add(q, &small[k], "small", "b", 5);
  int passed = 0;
  while (job_queue_take(q, fits, &room) != NULL) passed++;
  assert_in_range(passed, 1, JOB_PATIENCE);
  room = 2;
  expect(q, "large");
  expect(q, "small");
  job_queue_free(&q);
  free(small);
}

/* Whatever the order of adding and taking: a higher priority first, and each submitter's jobs of
 * one priority in their order. */
static void test_random(void **state) {
  enum { COUNT = 2000 };
  static const char *const submitters[] = {"a", "b", "c"};
  uint64_t r = seed_new("random");
  entry *e = calloc(COUNT, sizeof *e);
  int priority[COUNT], last[3][JOB_PRIORITIES];
  job_queue *q = job_queue_new();
  (void)state;
  memset(last, -1, sizeof last);
  for (int k = 0; k < COUNT; k++) {
    const int who = seed_below(&r, 3);
    priority[k] = seed_below(&r, JOB_PRIORITIES);
    add(q, &e[k], "", submitters[who], priority[k]);
    e[k].size = who;
  }
  int before = JOB_PRIORITIES;
  for (int n = 0; n < COUNT; n++) {
    const entry *got = job_queue_take(q, always, NULL);
    assert_non_null(got);
    const int k = (int)(got - e);
    assert_true(priority[k] <= before);
    assert_true(k > last[got->size][priority[k]]);
    before = priority[k];
    last[got->size][priority[k]] = k;
  }
  job_queue_free(&q);
  free(e);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_order_of_one), cmocka_unit_test(test_priority),
      cmocka_unit_test(test_turns),        cmocka_unit_test(test_remove),
      cmocka_unit_test(test_fit),          cmocka_unit_test(test_random),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
