/* exchange.h and admit.h: targets, hosts, ids, framing, replies. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "admit.h"
#include "exchange.h"

static void test_paths(void **state) {
  (void)state;
  static const char *const rows[][2] = {{"/", "/"},
                                        {"/a/b?c=d", "/a/b"},
                                        {"/a%2fb%20c", "/a%2Fb c"},
                                        {"/%c3%A4", "/\xc3\xa4"},
                                        {"http://h:1/a?b", "/a"},
                                        {"HTTPS://h", "/"},
                                        {"http://h?x", "/"},
                                        {"*", "*"},
                                        {"/?/%00", "/"},
                                        {"/a%00", NULL},
                                        {"/%", NULL},
                                        {"/%4", NULL},
                                        {"/%4g", NULL},
                                        {"/%?4", NULL},
                                        {"a", NULL},
                                        {"", NULL},
                                        {"ftp://h/", NULL}};
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    exchange *x = exchange_new(rows[k][0]);
    assert_int_equal(exchange_find_path(x), rows[k][1] != NULL);
    assert_string_equal(x->path, rows[k][1] != NULL ? rows[k][1] : "");
    exchange_free(&x);
    assert_null(x);
  }
}

static void test_hosts(void **state) {
  (void)state;
  static const char *const good[] = {"a",     "a.b-c_d~:1",   "127.0.0.1:65535",
                                     "[::1]", "[fe80::1]:80", "a:"};
  static const char *const bad[] = {"",    ":1", "a b",      "a:b",    "a:123456", "a/",
                                    "a\"", "[",  "[]",       "[::1",   "[::1]x",   "a:1:2",
                                    "a@b", "<",  "\xc3\xa4", "[::1]:x"};
  for (size_t k = 0; k < sizeof good / sizeof *good; k++) assert_true(exchange_is_host(good[k]));
  for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) assert_false(exchange_is_host(bad[k]));
  char longest[300];
  memset(longest, 'a', sizeof longest);
  longest[256] = '\0';
  assert_false(exchange_is_host(longest));
  longest[255] = '\0';
  assert_true(exchange_is_host(longest));
}

static void test_ids(void **state) {
  (void)state;
  exchange *x = exchange_new("/");
  char last[65] = "";
  static const char *const bad[] = {NULL, "", "a b", "a\n", "\xff", "a/b"};
  exchange_identify(x, "Ab_9.-");
  assert_string_equal(x->id, "Ab_9.-");
  for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
    exchange_identify(x, bad[k]);
    assert_true(strlen(x->id) > 10);
    assert_string_not_equal(x->id, last);
    strcpy(last, x->id);
  }
  exchange_free(&x);
}

static void test_later_reply_wins_and_frees(void **state) {
  (void)state;
  exchange *x = exchange_new("/");
  exchange_bytes(x, 200, "text/plain", strdup("abc"), 3);
  exchange_refuse(x, 400, "got \"%s\"", "x");
  assert_int_equal(x->reply.status, 400);
  assert_string_equal(x->reply.type, "application/problem+json");
  assert_int_equal(x->reply.size, strlen(x->reply.bytes));
  x->plain_problem = true;
  exchange_refuse(x, 404, "no");
  assert_string_equal(x->reply.type, "application/json");
  exchange_text(x, 200, "text/plain", "hello");
  assert_int_equal(x->reply.size, 5);
  exchange_free(&x);
}

static void test_fields(void **state) {
  (void)state;
  exchange *x = exchange_new("/");
  char wide[EXCHANGE_BASE + 400];
  memset(wide, 'a', sizeof wide);
  wide[sizeof wide - 1] = '\0';
  exchange_add(x, "Wide", "%s", wide);
  assert_int_equal(x->reply.fields, 0);
  for (int k = 0; k < 2 * EXCHANGE_FIELDS; k++) exchange_add(x, "A", "%d", k);
  assert_int_equal(x->reply.fields, EXCHANGE_FIELDS);
  assert_string_equal(x->reply.field[3].value, "3");
  exchange_free(&x);
}

static const http_place place = {.listener = -1, .host = "127.0.0.1:1", .rule = HOST_ANY};

/* What admit says of a request that is fine but for what `change` does to its head. */
static int status_of(const char *target, void (*change)(head *h, parameters *set)) {
  parameters set;
  param_defaults(&set);
  head h = {.method = "POST", .size = 100, .host = "a", .hosts = 1, .length = "3", .lengths = 1};
  exchange *x = exchange_new(target);
  change(&h, &set);
  const bool good = admit(x, &h, &set, &place);
  const int status = x->reply.status;
  assert_int_equal(good, status == 0);
  exchange_free(&x);
  return status;
}

static void no_change(head *h, parameters *set) {
  (void)h, (void)set;
}
static void two_hosts(head *h, parameters *set) {
  (void)set, h->hosts = 2;
}
static void bad_host(head *h, parameters *set) {
  (void)set, h->host = "a b";
}
static void no_host(head *h, parameters *set) {
  (void)set, h->host = NULL, h->hosts = 0;
}
static void old(head *h, parameters *set) {
  no_host(h, set), h->old = true;
}
static void two_lengths(head *h, parameters *set) {
  (void)set, h->lengths = 2;
}
static void both(head *h, parameters *set) {
  (void)set, h->coding = "chunked", h->codings = 1;
}
static void odd_coding(head *h, parameters *set) {
  (void)set, h->length = NULL, h->lengths = 0, h->coding = "gzip", h->codings = 1;
}
static void chunked(head *h, parameters *set) {
  odd_coding(h, set), h->coding = "Chunked";
}
static void large(head *h, parameters *set) {
  (void)h, set->limits.body_bytes = 2;
}
static void fits(head *h, parameters *set) {
  (void)h, set->limits.body_bytes = 3;
}
static void broken(head *h, parameters *set) {
  (void)set, h->broken = true;
}
static void long_head(head *h, parameters *set) {
  h->size = (size_t)set->header_bytes + 1;
}
static void short_room(head *h, parameters *set) {
  (void)h, set->header_bytes = 8;
}

static void test_admission(void **state) {
  (void)state;
  static const struct {
    void (*change)(head *, parameters *);
    int status;
  } rows[] = {{no_change, 0}, {two_hosts, 400},   {bad_host, 400},   {no_host, 400}, {old, 0},
              {both, 400},    {two_lengths, 400}, {odd_coding, 501}, {chunked, 0},   {large, 413},
              {fits, 0},      {long_head, 431},   {short_room, 414}, {broken, 400}};
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    assert_int_equal(status_of("/12345", rows[k].change), rows[k].status);
  }
  assert_int_equal(status_of("/%", no_change), 400);
}

static void test_base(void **state) {
  (void)state;
  static const char *const rows[][3] = {{"", "h:1", "http://h:1"},
                                        {"", "b a d", "http://127.0.0.1:1"},
                                        {"", NULL, "http://127.0.0.1:1"},
                                        {"https://a/b//", "h", "https://a/b"}};
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    parameters set;
    head h = {.method = "GET", .host = rows[k][1], .hosts = rows[k][1] != NULL};
    exchange *x = exchange_new("/");
    param_defaults(&set);
    strcpy(set.public_url, rows[k][0]);
    (void)admit(x, &h, &set, &place);
    assert_string_equal(x->base, rows[k][2]);
    exchange_free(&x);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_paths),  cmocka_unit_test(test_hosts),
      cmocka_unit_test(test_ids),    cmocka_unit_test(test_later_reply_wins_and_frees),
      cmocka_unit_test(test_fields), cmocka_unit_test(test_admission),
      cmocka_unit_test(test_base),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
