/* store.h, keep.h: rows, filters, files; one daemon at a time. With the URL of a PostgreSQL
 * database in $SCATTERD_STORE everything runs on that, and what only a shared store has
 * (store_shared.h). */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <sqlite3.h>
#include <stdio.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#include "keep.h"
#include "media.h"
#include "store_shared.h"

static char directory[] = "/tmp/store-test-XXXXXX";
static const char *url = "";

static store *opened(void) {
  fault why;
  store *s = store_open(directory, url, &why);
  if (s == NULL) fail_msg("%s", why.text);
  return s;
}

/* Empties the database, if it is one that others keep. */
static int clear(void) {
  char command[600];
  if (*url == '\0') return 0;
  snprintf(command, sizeof command,
           "psql -X -q '%s' -c 'SET client_min_messages = error; DROP SCHEMA public CASCADE; "
           "CREATE SCHEMA public' >/dev/null",
           url);
  return system(command);
}

static int make_directory(void **state) {
  (void)state;
  if (clear() != 0) return -1;
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
  assert_null(store_open(directory, url, &why));
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
  assert_true(store_first_expiry(s, 0) == 50);
  l.count = 0;
  assert_int_equal(store_expired(s, 49, note, &l), STORE_OK);
  assert_int_equal(l.count, 0);
  assert_int_equal(store_expired(s, 50, note, &l), STORE_OK);
  assert_int_equal(l.count, 1);
  assert_int_equal(store_remove(s, parent), STORE_OK);
  assert_int_equal(store_job_number(s, parent + 2, &back), STORE_NONE);
  assert_true(store_first_expiry(s, 0) == INFINITY);
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
  unlinkat(at, "a", 0);
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

/* ---- Of other versions ---- */

static void run_sql(const char *text) {
  char file[64];
  sqlite3 *db = NULL;
  snprintf(file, sizeof file, "%s/" STORE_DATABASE, directory);
  assert_int_equal(sqlite3_open(file, &db), SQLITE_OK);
  assert_int_equal(sqlite3_exec(db, text, NULL, NULL, NULL), SQLITE_OK);
  sqlite3_close(db);
}

/* What version 2 added is taken away. */
static void test_old_tables_become_new(void **state) {
  store *s = opened();
  job_row row = a_row(1), back;
  (void)state;
  add(s, &row);
  store_close(&s);
  run_sql(
      "ALTER TABLE jobs DROP COLUMN holder; ALTER TABLE jobs DROP COLUMN phase;"
      "ALTER TABLE jobs DROP COLUMN residual; ALTER TABLE calls DROP COLUMN holder;"
      "ALTER TABLE data DROP COLUMN owner; PRAGMA user_version = 1");
  s = opened();
  assert_int_equal(store_job(s, row.id, &back), STORE_OK);
  assert_memory_equal(&back, &row, sizeof row);
  assert_int_equal(store_update(s, &back, "", NULL, 0), STORE_OK);
  store_close(&s);
}

static void test_future_tables_are_left_alone(void **state) {
  store *s = opened();
  fault why;
  (void)state;
  store_close(&s);
  run_sql("PRAGMA user_version = 99");
  assert_null(store_open(directory, url, &why));
  assert_non_null(strstr(why.text, "version 99"));
}

static void test_future_tables_of_others(void **state) {
  store *s = opened();
  char command[600];
  fault why;
  (void)state;
  store_close(&s);
  snprintf(command, sizeof command, "psql -X -q '%s' -c 'UPDATE scatterd SET version = 99'", url);
  assert_int_equal(system(command), 0);
  assert_null(store_open(directory, url, &why));
  assert_non_null(strstr(why.text, "version 99"));
}

/* ---- Of a store that several share ---- */

static const char me[] = "me", you[] = "you";

static void live(store *s, const char *holder) {
  double now = 0;
  assert_int_equal(store_beat(s, holder, &now), STORE_OK);
  assert_true(fabs(now - (double)time(NULL)) < 100);
}

/* Number of the job that is taken, 0 for none. */
static int64_t take(store *s, const char *holder, int64_t room) {
  job_row row;
  const store_result result = store_take(s, holder, room, 0, &row);
  if (result == STORE_NONE) return 0;
  assert_int_equal(result, STORE_OK);
  assert_string_equal(row.holder, holder);
  return row.number;
}

static int64_t add_for(store *s, int k, const char *submitter, int priority) {
  job_row row = a_row(k);
  row.priority = priority;
  row.estimate = 100 + k;
  snprintf(row.submitter, sizeof row.submitter, "%s", submitter);
  return add(s, &row);
}

static void test_taking_turns(void **state) {
  store *s = opened();
  (void)state;
  int64_t a[3], b[1];
  for (int k = 0; k < 3; k++) a[k] = add_for(s, k, "a", 5);
  b[0] = add_for(s, 3, "b", 5);
  const int64_t low = add_for(s, 4, "c", 2), high = add_for(s, 5, "c", 7);
  assert_int_equal(store_waiting(s), 6);
  assert_int_equal(store_active_of(s, "a"), 3);
  assert_int_equal(take(s, me, 99), 0); /* nothing is so small */
  assert_int_equal(take(s, me, 1000), high);
  const int64_t first = take(s, me, 1000), second = take(s, you, 1000);
  assert_true((first == a[0] && second == b[0]) || (first == b[0] && second == a[0]));
  assert_int_equal(take(s, me, 1000), a[1]);
  assert_int_equal(take(s, me, 1000), a[2]);
  assert_int_equal(take(s, me, 1000), low);
  assert_int_equal(take(s, me, 1000), 0);
  assert_int_equal(store_waiting(s), 0);
  store_close(&s);
}

static void test_only_the_holder_changes(void **state) {
  store *s = opened();
  (void)state;
  job_row row = a_row(1), back;
  add(s, &row);
  assert_int_equal(store_claim(s, me, &row), STORE_OK);
  assert_int_equal(store_claim(s, you, &row), STORE_NONE);
  row.state = JOB_RUNNING;
  snprintf(row.holder, sizeof row.holder, "%s", me);
  assert_int_equal(store_update(s, &row, you, NULL, 0), STORE_NONE);
  assert_int_equal(store_update(s, &row, me, NULL, 0), STORE_OK);
  row.progress = 50;
  row.residual = 1e-5;
  snprintf(row.phase, sizeof row.phase, "factor");
  assert_int_equal(store_progress(s, &row), STORE_OK);
  assert_int_equal(store_job(s, row.id, &back), STORE_OK);
  assert_memory_equal(&back, &row, sizeof row);
  snprintf(back.holder, sizeof back.holder, "%s", you);
  assert_int_equal(store_progress(s, &back), STORE_NONE);
  list held = {0};
  assert_int_equal(store_held(s, me, note, &held), STORE_OK);
  assert_int_equal(held.count, 1);
  assert_int_equal(held.number[0], row.number);
  store_close(&s);
}

static int count_held(store *s, const char *holder) {
  list held = {0};
  assert_int_equal(store_held(s, holder, note, &held), STORE_OK);
  return held.count;
}

/* Buries until it has an effect: only a server that has been up for a lease lets anybody be dead.
 */
static void bury(store *s, bool (*is_done)(store *s)) {
  for (int tries = 0; tries < 600 && !is_done(s); tries++) {
    live(s, "third");
    assert_int_equal(store_bury(s, me, 3), STORE_OK);
    if (!is_done(s)) usleep(50000);
  }
  assert_true(is_done(s));
}

static bool have_one(store *s) {
  return count_held(s, me) > 0;
}

static void test_the_dead_are_buried(void **state) {
  store *s = opened();
  static const char *const holders[] = {you, you, "third"};
  job_row row[3];
  (void)state;
  for (int k = 0; k < 3; k++) {
    row[k] = a_row(k);
    add(s, &row[k]);
    assert_int_equal(store_claim(s, holders[k], &row[k]), STORE_OK);
    snprintf(row[k].holder, sizeof row[k].holder, "%s", holders[k]);
    row[k].state = k == 1 ? JOB_ACCEPTED : JOB_RUNNING;
    assert_int_equal(store_update(s, &row[k], holders[k], NULL, 0), STORE_OK);
  }
  bury(s, have_one);
  assert_int_equal(count_held(s, me), 1);                  /* what was running */
  assert_int_equal(count_held(s, "third"), 1);             /* who lives */
  assert_int_equal(take(s, me, INT64_MAX), row[1].number); /* what was only taken */
  store_close(&s);
}

static bool is_due(store *s) {
  job_call call = {0};
  assert_int_equal(store_calls(s, 1, note_call, &call), STORE_OK);
  return call.due < 1e11;
}

static void test_calls_are_claimed(void **state) {
  store *s = opened();
  (void)state;
  job_call call, again;
  assert_int_equal(store_add_call(s, 7, 2, 20), STORE_OK);
  assert_int_equal(store_calls(s, 1, note_call, &call), STORE_OK);
  again = call;
  call.attempts = again.attempts = 1;
  call.due = again.due = 1e12;
  assert_int_equal(store_claim_call(s, me, &call), STORE_OK);
  assert_int_equal(store_claim_call(s, you, &again), STORE_NONE);
  bury(s, is_due); /* who claimed it has never beaten */
  store_close(&s);
}

static void test_large_bytes(void **state) {
  enum { SIZE = 2500000 };
  store *s = opened();
  char *bytes = malloc(SIZE), *back = malloc(SIZE);
  (void)state;
  for (size_t k = 0; k < SIZE; k++) bytes[k] = (char)(k * k >> 7);
  const int from = memfd_create("from", 0);
  assert_int_equal(write(from, bytes, SIZE), SIZE);
  assert_int_equal(store_open_large(s, "x", 1), -1);
  assert_int_equal(errno, ENOENT);
  assert_int_equal(store_add_large(s, "x", 1, from, SIZE), STORE_OK);
  int fd = store_open_large(s, "x", 1);
  assert_int_equal(lseek(fd, 0, SEEK_END), SIZE);
  assert_int_equal(pread(fd, back, SIZE, 0), SIZE);
  assert_memory_equal(bytes, back, SIZE);
  assert_int_equal(pwrite(fd, "x", 1, 0), -1); /* a worker is given it to read */
  close(fd);
  assert_int_equal(store_add_large(s, "x", 1, from, 10), STORE_OK); /* in place of the longer one */
  fd = store_open_large(s, "x", 1);
  assert_int_equal(lseek(fd, 0, SEEK_END), 10);
  close(fd);
  assert_int_equal(store_drop_large(s, "x", 0, 0), STORE_OK);
  assert_int_equal(close(store_open_large(s, "x", 1)), 0);
  assert_int_equal(store_drop_large(s, "x", 0, 1), STORE_OK);
  assert_int_equal(store_open_large(s, "x", 1), -1);
  close(from);
  free(bytes);
  free(back);
  store_close(&s);
}

static void assert_hears(store *s, const char *expected) {
  char *text = NULL;
  for (int tries = 0; tries < 3000 && (text = store_hear(s)) == NULL; tries++) usleep(10000);
  assert_non_null(text);
  assert_string_equal(text, expected);
  free(text);
}

/* What one daemon tells another hears, once, in order; not what it told itself. */
static void test_telling(void **state) {
  store *s = opened();
  char second[] = "/tmp/store-test-XXXXXX", command[64];
  fault why;
  (void)state;
  assert_non_null(mkdtemp(second));
  store *other = store_open(second, url, &why);
  assert_non_null(other);
  assert_int_equal(store_tell(s, "first"), STORE_OK);
  assert_int_equal(store_begin(s), STORE_OK);
  assert_int_equal(store_tell(s, "undone"), STORE_OK);
  store_rollback(s);
  assert_int_equal(store_tell(s, "second"), STORE_OK);
  assert_hears(other, "first");
  assert_hears(other, "second");
  assert_null(store_hear(s));
  store_close(&other);
  snprintf(command, sizeof command, "rm -r %s", second);
  assert_int_equal(system(command), 0);
  store_close(&s);
}

/* The database takes only UTF-8; keys may hold anything. */
static void test_any_bytes(void **state) {
  store *s = opened();
  job_row row = a_row(1), back;
  const job_extra extra = {.key = "caf\xe9 \xff"};
  char digest[JOB_DIGEST];
  (void)state;
  assert_int_equal(store_add(s, &row, &extra), STORE_OK);
  assert_int_equal(store_by_key(s, row.submitter, extra.key, &back, digest), STORE_OK);
  store_close(&s);
}

static void test_a_key_is_taken_once(void **state) {
  store *s = opened();
  job_row row = a_row(1), other = a_row(2);
  const job_extra extra = {.key = "k"};
  (void)state;
  assert_int_equal(store_add(s, &row, &extra), STORE_OK);
  assert_int_equal(store_begin(s), STORE_OK);
  assert_int_equal(store_add(s, &other, &extra), STORE_TAKEN);
  assert_int_not_equal(store_commit(s), STORE_OK); /* nothing of it is there */
  store_rollback(s);
  assert_int_equal(store_job(s, other.id, &other), STORE_NONE);
  store_close(&s);
}

/* One that a failure of the store became is again what it was, as far as a client is told. */
static void test_errors(void **state) {
  (void)state;
  static const struct {
    int error;
    store_result means;
  } cases[] = {{0, STORE_OK},        {ENOSPC, STORE_FULL},   {EDQUOT, STORE_FULL},
               {ENOMEM, STORE_DOWN}, {EMFILE, STORE_DOWN},   {ENFILE, STORE_DOWN},
               {EIO, STORE_FAILED},  {ENOENT, STORE_FAILED}, {EROFS, STORE_FAILED}};
  static const store_result back[] = {STORE_OK, STORE_FULL, STORE_DOWN, STORE_FAILED};
  for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
    assert_int_equal(store_result_of(cases[k].error), cases[k].means);
    assert_int_equal(store_blame("test", cases[k].error), cases[k].means);
  }
  for (size_t k = 0; k < sizeof back / sizeof *back; k++) {
    assert_int_equal(store_result_of(store_errno(back[k])), back[k]);
  }
}

static int64_t size_of_large(store *s, const char *owner, int which) {
  const int fd = store_open_large(s, owner, which);
  const int64_t size = fd < 0 ? -1 : (int64_t)lseek(fd, 0, SEEK_END);
  if (fd >= 0) close(fd);
  return size;
}

static int adopt(store *s, const char *draft, int fd, size_t size) {
  assert_int_equal(store_begin(s), STORE_OK);
  return (int)store_adopt(s, draft, "x", 1, fd, size);
}

static void test_drafts(void **state) {
  enum { SIZE = 2500000 };
  store *s = opened();
  char draft[STORE_DRAFT], other[STORE_DRAFT];
  (void)state;
  const int from = memfd_create("from", 0), little = memfd_create("little", 0);
  assert_int_equal(ftruncate(from, SIZE), 0);
  assert_int_equal(ftruncate(little, 1), 0);
  store_sign(s, me);
  store_name_draft(s, draft);
  store_name_draft(s, other);
  assert_string_not_equal(draft, other);
  assert_int_equal(store_write_draft(s, draft, from, SIZE), 0);
  assert_int_equal(size_of_large(s, "x", 1), -1);
  assert_int_equal(adopt(s, draft, little, 1), STORE_OK);
  store_rollback(s); /* it is one as before */
  assert_int_equal(size_of_large(s, "x", 1), -1);
  assert_int_equal(adopt(s, draft, little, 1), STORE_OK);
  assert_int_equal(store_commit(s), STORE_OK);
  assert_int_equal(size_of_large(s, "x", 1), SIZE);                /* the draft's */
  assert_int_not_equal(store_write_draft(s, other, little, 2), 0); /* there is not that much */
  assert_int_equal(size_of_large(s, other, -1), -1);
  store_drop_draft(s, draft);
  store_drop_draft(s, other);
  assert_int_equal(size_of_large(s, "x", 1), SIZE);
  assert_int_equal(adopt(s, draft, little, 1), STORE_OK); /* which has gone: written now */
  assert_int_equal(store_commit(s), STORE_OK);
  assert_int_equal(size_of_large(s, "x", 1), 1);
  close(from);
  close(little);
  store_close(&s);
}

#define CASE(f) cmocka_unit_test_setup_teardown(f, make_directory, remove_directory)

int main(void) {
  const struct CMUnitTest both[] = {
      CASE(test_row_comes_back),     CASE(test_one_at_a_time), CASE(test_transactions),
      CASE(test_keys_and_digests),   CASE(test_filters),       CASE(test_active_parts_and_expiry),
      CASE(test_log_and_calls),      CASE(test_files),         CASE(test_any_bytes),
      cmocka_unit_test(test_errors),
  };
  const struct CMUnitTest own[] = {
      CASE(test_old_tables_become_new),
      CASE(test_future_tables_are_left_alone),
  };
  const struct CMUnitTest shared[] = {
      CASE(test_future_tables_of_others),
      CASE(test_taking_turns),
      CASE(test_only_the_holder_changes),
      CASE(test_the_dead_are_buried),
      CASE(test_calls_are_claimed),
      CASE(test_large_bytes),
      CASE(test_drafts),
      CASE(test_telling),
      CASE(test_a_key_is_taken_once),
  };
  if (getenv("SCATTERD_STORE") != NULL) url = getenv("SCATTERD_STORE");
  const int failed = cmocka_run_group_tests(both, NULL, NULL);
  return failed + (*url != '\0' ? cmocka_run_group_tests(shared, NULL, NULL)
                                : cmocka_run_group_tests(own, NULL, NULL));
}
