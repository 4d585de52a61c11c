/* store.h, keep.h: rows, filters, files; one daemon at a time. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <sys/mman.h>
#include <unistd.h>

#include "keep.h"
#include "media.h"
#include "store.h"

static char directory[] = "/tmp/store-test-XXXXXX";

static store *opened(void) {
  fault why;
  store *s = store_open(directory, &why);
  if (s == NULL) fail_msg("%s", why.text);
  return s;
}

static int make_directory(void **state) {
  (void)state;
  strcpy(directory, "/tmp/store-test-XXXXXX");
  return mkdtemp(directory) == NULL;
}

static int remove_directory(void **state) {
  char command[128];
  (void)state;
  snprintf(command, sizeof command, "rm -r %s", directory);
  return system(command);
}

static job_row a_row(int k) {
  job_row row = {.state = JOB_ACCEPTED,
                 .priority = 3,
                 .content = MEDIA_CBOR,
                 .size = 1LL << 40,
                 .points = 17,
                 .estimate = 1LL << 41,
                 .created = 1000.25 + k,
                 .updated = 2000};
  snprintf(row.id, sizeof row.id, "%032d", k);
  snprintf(row.process, sizeof row.process, k % 2 ? "solve" : "echo");
  snprintf(row.submitter, sizeof row.submitter, "me");
  snprintf(row.message, sizeof row.message, "it's \"quoted\"");
  return row;
}

static int64_t add(store *s, job_row *row) {
  static const job_extra none;
  assert_int_equal(store_add(s, row, &none), STORE_OK);
  return row->number;
}

static void test_row_comes_back(void **state) {
  store *s = opened();
  job_row row = a_row(1), back;
  job_extra extra = {.key = "key", .digest = "abc", .uri = {"http://a/s", "", "http://a/f"}},
            got = {0};
  (void)state;
  assert_int_equal(store_add(s, &row, &extra), STORE_OK);
  store_close(&s);
  assert_null(s);
  s = opened();
  assert_int_equal(store_job(s, row.id, &back), STORE_OK);
  assert_memory_equal(&back, &row, sizeof row);
  row.state = JOB_FAILED;
  row.status = 422;
  row.finished = 3000.125;
  assert_int_equal(store_update(s, &row, "", "problem", 7), STORE_OK);
  assert_int_equal(store_job_number(s, row.number, &back), STORE_OK);
  assert_memory_equal(&back, &row, sizeof row);
  size_t size = 0;
  char *problem = store_problem(s, row.number, &size);
  assert_int_equal(size, 7);
  assert_memory_equal(problem, "problem", 7);
  free(problem);
  assert_int_equal(store_extra(s, row.number, &got), STORE_OK);
  assert_memory_equal(&got, &extra, sizeof got);
  assert_int_equal(store_job(s, "none", &back), STORE_NONE);
  store_close(&s);
}

static void test_one_at_a_time(void **state) {
  store *s = opened();
  fault why;
  (void)state;
  assert_null(store_open(directory, &why));
  assert_non_null(strstr(why.text, "another daemon"));
  store_close(&s);
  s = opened();
  store_close(&s);
}

static void test_transactions(void **state) {
  store *s = opened();
  job_row row = a_row(1), back;
  (void)state;
  assert_int_equal(store_begin(s), STORE_OK);
  add(s, &row);
  store_rollback(s);
  assert_int_equal(store_job(s, row.id, &back), STORE_NONE);
  assert_int_equal(store_begin(s), STORE_OK);
  add(s, &row);
  assert_int_equal(store_commit(s), STORE_OK);
  assert_int_equal(store_job(s, row.id, &back), STORE_OK);
  store_rollback(s); /* nothing to undo */
  store_close(&s);
}

static void test_keys_and_digests(void **state) {
  store *s = opened();
  job_row row = a_row(1), back;
  const job_extra extra = {.key = "k", .digest = "d"};
  char digest[JOB_DIGEST];
  (void)state;
  row.state = JOB_SUCCESSFUL;
  row.reusable = 1;
  row.expires = 500;
  assert_int_equal(store_add(s, &row, &extra), STORE_OK);
  assert_int_equal(store_by_key(s, "me", "k", &back, digest), STORE_OK);
  assert_string_equal(digest, "d");
  assert_int_equal(store_by_key(s, "you", "k", &back, digest), STORE_NONE);
  assert_int_equal(store_by_key(s, "me", "", &back, digest), STORE_NONE);
  assert_int_equal(store_by_digest(s, "", "d", 499, &back), STORE_OK);
  assert_int_equal(store_by_digest(s, "me", "d", 499, &back), STORE_OK);
  assert_int_equal(store_by_digest(s, "you", "d", 499, &back), STORE_NONE);
  assert_int_equal(store_by_digest(s, "", "d", 501, &back), STORE_NONE);
  row.reusable = 0;
  assert_int_equal(store_update(s, &row, "", NULL, 0), STORE_OK);
  assert_int_equal(store_by_digest(s, "", "d", 499, &back), STORE_NONE);
  store_close(&s);
}

typedef struct {
  int count;
  int64_t number[20];
} list;

static bool note(void *context, const job_row *row) {
  list *l = context;
  l->number[l->count++] = row->number;
  return true;
}

static list filtered(store *s, store_filter f) {
  list l = {0};
  if (f.states == 0) f.states = ~0u;
  if (f.limit == 0) f.limit = 20;
  if (f.created_most == 0) f.created_most = INFINITY;
  assert_int_equal(store_list(s, &f, note, &l), STORE_OK);
  return l;
}

static void test_filters(void **state) {
  store *s = opened();
  (void)state;
  for (int k = 0; k < 6; k++) {
    job_row row = a_row(k);
    row.state = k % JOB_STATES;
    row.started = k == 0 ? 0 : 100;
    row.finished = k < 3 ? 0 : 100 + 10 * k;
    row.parent = k == 5 ? 3 : 0;
    add(s, &row);
  }
  list l = filtered(s, (store_filter){.limit = 3, .offset = 1});
  assert_int_equal(l.count, 3);
  assert_int_equal(l.number[0], 4); /* 6 is a part, 5 is skipped */
  assert_int_equal(filtered(s, (store_filter){.has_parent = true, .parent = 3}).number[0], 6);
  assert_int_equal(filtered(s, (store_filter){.processes = ",solve,"}).count, 2);
  assert_int_equal(filtered(s, (store_filter){.processes = ",solve,echo,"}).count, 5);
  assert_int_equal(filtered(s, (store_filter){.processes = ",sol,"}).count, 0);
  assert_int_equal(filtered(s, (store_filter){.states = 1u << JOB_RUNNING}).number[0], 2);
  const store_filter time = {.created_least = 1001.25, .created_most = 1002.25};
  assert_int_equal(filtered(s, time).count, 2);
  const store_filter lasted = {.timed = true, .seconds_least = 35, .seconds_most = 50, .now = 140};
  l = filtered(s, lasted); /* 2 and 3 still run, for 40 s; 5 took 40 s */
  assert_int_equal(l.count, 3);
  store_close(&s);
}

static void test_active_parts_and_expiry(void **state) {
  store *s = opened();
  list l = {0};
  int64_t count[JOB_STATES];
  job_row back;
  (void)state;
  job_row batch = a_row(0);
  batch.parts = 3;
  batch.expires = 50;
  const int64_t parent = add(s, &batch);
  for (int k = 0; k < 3; k++) {
    job_row row = a_row(k + 1);
    row.parent = parent;
    row.part = k;
    row.state = k == 0 ? JOB_RUNNING : JOB_SUCCESSFUL;
    row.finished = k == 0 ? 0 : 100 - k;
    add(s, &row);
  }
  assert_int_equal(store_active(s, note, &l), STORE_OK);
  assert_int_equal(l.count, 2);
  assert_int_equal(store_part(s, parent, 1, &back), STORE_OK);
  assert_int_equal(back.number, parent + 2);
  assert_int_equal(store_part(s, parent, 3, &back), STORE_NONE);
  assert_int_equal(store_next_ended(s, parent, 0, &back), STORE_OK);
  assert_int_equal(back.part, 2);
  assert_int_equal(store_next_ended(s, parent, back.finished, &back), STORE_OK);
  assert_int_equal(back.part, 1);
  assert_int_equal(store_next_ended(s, parent, back.finished, &back), STORE_NONE);
  assert_int_equal(store_part_states(s, parent, count), STORE_OK);
  assert_int_equal(count[JOB_SUCCESSFUL], 2);
  assert_int_equal(count[JOB_RUNNING], 1);
  assert_true(store_first_expiry(s) == 50);
  l.count = 0;
  assert_int_equal(store_expired(s, 49, note, &l), STORE_OK);
  assert_int_equal(l.count, 0);
  assert_int_equal(store_expired(s, 50, note, &l), STORE_OK);
  assert_int_equal(l.count, 1);
  assert_int_equal(store_remove(s, parent), STORE_OK);
  assert_int_equal(store_job_number(s, parent + 2, &back), STORE_NONE);
  assert_true(store_first_expiry(s) == INFINITY);
  store_close(&s);
}

static void note_line(void *context, double time, const char *text) {
  char *all = context;
  sprintf(all + strlen(all), "%g %s;", time, text);
}

static void note_call(void *context, const job_call *call) {
  *(job_call *)context = *call;
}

static void test_log_and_calls(void **state) {
  store *s = opened();
  char all[100] = "";
  job_call call = {0};
  (void)state;
  for (int k = 0; k < 5; k++) assert_int_equal(store_log(s, 7, k, k == 4 ? "d" : "x"), STORE_OK);
  assert_int_equal(store_read_log(s, 7, 2, note_line, all), STORE_OK);
  assert_string_equal(all, "3 x;4 d;");
  assert_int_equal(store_add_call(s, 7, 2, 20), STORE_OK);
  assert_int_equal(store_add_call(s, 7, 1, 10), STORE_OK);
  assert_int_equal(store_calls(s, 1, note_call, &call), STORE_OK);
  assert_int_equal(call.kind, 1);
  call.attempts = 3;
  call.due = 30;
  assert_int_equal(store_update_call(s, &call), STORE_OK);
  assert_int_equal(store_calls(s, 2, note_call, &call), STORE_OK); /* the later one is kept */
  assert_int_equal(call.attempts, 3);
  assert_int_equal(store_remove_call(s, call.number), STORE_OK);
  assert_int_equal(store_calls(s, 2, note_call, &call), STORE_OK);
  assert_int_equal(call.kind, 2);
  store_close(&s);
}

static bool is_wanted(void *context, const char *name) {
  return strcmp(name, context) == 0;
}

static void test_files(void **state) {
  store *s = opened();
  const int at = store_files(s), from = memfd_create("from", 0);
  char bytes[8] = "";
  (void)state;
  assert_int_equal(write(from, "content", 7), 7);
  assert_true(keep_file(at, "a", from, 7));
  assert_true(keep_link(at, "a", "b"));
  keep_drop(at, "a");
  assert_int_equal(keep_open(at, "a"), -1);
  const int back = keep_open(at, "b");
  assert_int_equal(read(back, bytes, sizeof bytes), 7);
  assert_string_equal(bytes, "content");
  close(back);
  assert_false(keep_file(at, "short", from, 8)); /* it has only 7 */
  assert_int_equal(keep_open(at, "short"), -1);
  assert_true(keep_file(at, "c", from, 7));
  keep_sweep(at, is_wanted, "c");
  assert_int_equal(keep_open(at, "b"), -1);
  const int kept = keep_open(at, "c");
  assert_true(kept >= 0);
  close(kept);
  close(from);
  store_close(&s);
}

#define CASE(f) cmocka_unit_test_setup_teardown(f, make_directory, remove_directory)

int main(void) {
  const struct CMUnitTest tests[] = {
      CASE(test_row_comes_back),   CASE(test_one_at_a_time), CASE(test_transactions),
      CASE(test_keys_and_digests), CASE(test_filters),       CASE(test_active_parts_and_expiry),
      CASE(test_log_and_calls),    CASE(test_files),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
