/* token.h: lines, files, secrets. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>

#include "token.h"

#define A "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa"
#define B "bbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbb"
/* of "one" and "two" */
#define ONE "7692c3ad3540bb803c020b3aee66cd8887123234ea0c6e7143c0add73ff431ed"
#define TWO "3fc4ccfe745870e2c0d99f71f30ff0656c8dedd41cc1d7d3d376b0dbe685e2f3"

static tokens *read_bytes(const char *text, size_t size, const tokens *old, fault *why) {
  char path[] = "/tmp/test-token-XXXXXX";
  const int fd = mkstemp(path);
  bool is_public;
  assert_int_equal(write(fd, text, size), (ssize_t)size);
  close(fd);
  tokens *t = tokens_read(path, old, &is_public, why);
  unlink(path);
  return t;
}

static tokens *read_text(const char *text, const tokens *old, fault *why) {
  return read_bytes(text, strlen(text), old, why);
}

static tokens *good(const char *text) {
  fault why;
  tokens *t = read_text(text, NULL, &why);
  if (t == NULL) fail_msg("%s", why.text);
  return t;
}

static void test_limits(void **state) {
  (void)state;
  tokens *t = good("# who may\n\n  alice sha256:" ONE
                   " jobs=3 points=2k seconds=0.5 body-bytes=3KiB data-bytes=0 job-bytes=5 "
                   "streams=4 rate=2.5 burst=7 # one\n"
                   "bob\tsha256:" TWO "\r\n");
  assert_int_equal(tokens_count(t), 2);
  const token_limits a = tokens_named(t, "alice")->most, b = tokens_named(t, "bob")->most;
  assert_true(a.jobs == 3 && a.points == 2000 && a.seconds == 0.5 && a.body_bytes == 3072);
  assert_true(a.data_bytes == 0 && a.job_bytes == 5 && a.rate == 2.5 && a.burst == 7);
  assert_true(a.streams == 4 && b.streams == INT64_MAX);
  assert_true(b.jobs == INT64_MAX && b.points == INT64_MAX && isinf(b.seconds) && isinf(b.rate));
  tokens_free(&t);
  assert_null(t);
}

static void test_secrets(void **state) {
  (void)state;
  tokens *t = good("alice sha256:" A " sha256:" ONE "\nbob sha256:" TWO "\n");
  assert_string_equal(tokens_holding(t, "one")->name, "alice");
  assert_string_equal(tokens_holding(t, "two")->name, "bob");
  assert_null(tokens_holding(t, "three"));
  assert_null(tokens_holding(t, ""));
  assert_null(tokens_holding(t, ONE));
  assert_null(tokens_named(t, "carol"));
  tokens_free(&t);
}

static void test_narrow(void **state) {
  limits l = {.points = 100, .body_bytes = 1000, .seconds = 10};
  (void)state;
  token_narrow(&token_unlimited, &l);
  assert_true(l.points == 100 && l.body_bytes == 1000 && l.seconds == 10);
  token_narrow(&(token_limits){.points = 7, .body_bytes = 2000, .seconds = 3}, &l);
  assert_true(l.points == 7 && l.body_bytes == 1000 && l.seconds == 3);
}

static void test_buckets_stay(void **state) {
  fault why;
  (void)state;
  tokens *t = good("alice sha256:" ONE " rate=1 burst=1\nbob sha256:" TWO "\n");
  assert_true(bucket_take(&tokens_named(t, "alice")->bucket, 1, 1, 10) == 0);
  tokens *next = read_text("bob sha256:" TWO "\nalice sha256:" A " rate=1 burst=1\n", t, &why);
  tokens_free(&t);
  assert_true(bucket_take(&tokens_named(next, "alice")->bucket, 1, 1, 10) > 0);
  assert_true(bucket_take(&tokens_named(next, "bob")->bucket, 1, 1, 10) == 0);
  tokens_free(&next);
}

static void test_made(void **state) {
  char secret[TOKEN_SECRET], other[TOKEN_SECRET], line[TOKEN_LINE], *words[] = {"jobs=2"};
  fault why;
  (void)state;
  assert_true(token_make("alice", 1, words, secret, line, &why));
  assert_int_equal(strlen(secret), TOKEN_SECRET - 1);
  assert_null(strstr(line, secret));
  tokens *t = good(line);
  assert_string_equal(tokens_holding(t, secret)->name, "alice");
  assert_int_equal(tokens_named(t, "alice")->most.jobs, 2);
  tokens_free(&t);
  assert_true(token_make("alice", 0, NULL, other, line, &why));
  assert_string_not_equal(secret, other);
  words[0] = "sha256:" A;
  assert_false(token_make("alice", 1, words, secret, line, &why));
  assert_false(token_make("127.0.0.1", 0, NULL, secret, line, &why));
  char *many[60];
  for (int k = 0; k < 60; k++) many[k] = "points=1000000";
  assert_false(token_make("alice", 60, many, secret, line, &why));
}

static void test_modes(void **state) {
  static const struct {
    mode_t mode;
    bool good, is_public;
  } rows[] = {{0600, true, false}, {0640, true, false},  {0644, true, true},
              {0604, true, true},  {0620, false, false}, {0602, false, false}};
  char path[] = "/tmp/test-token-XXXXXX";
  const int fd = mkstemp(path);
  fault why;
  (void)state;
  assert_true(write(fd, "alice sha256:" A, 77) == 77);
  close(fd);
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    bool is_public = false;
    chmod(path, rows[k].mode);
    tokens *t = tokens_read(path, NULL, &is_public, &why);
    assert_int_equal(t != NULL, rows[k].good);
    if (t != NULL) assert_int_equal(is_public, rows[k].is_public);
    tokens_free(&t);
  }
  unlink(path);
}

static void test_no_text(void **state) {
  static const char text[] = "alice sha256:" A "\nbob sha256:" B " \0jobs=1\n";
  fault why;
  (void)state;
  assert_null(read_bytes(text, sizeof text - 1, NULL, &why));
  assert_non_null(strstr(why.text, ":2: got a NUL"));
  assert_null(read_text("", NULL, &why));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_limits), cmocka_unit_test(test_secrets),
      cmocka_unit_test(test_narrow), cmocka_unit_test(test_buckets_stay),
      cmocka_unit_test(test_made),   cmocka_unit_test(test_modes),
      cmocka_unit_test(test_no_text)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
