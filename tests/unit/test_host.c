/* host.h: by which names the service may be called. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <stdio.h>

#include "host.h"

static void test_rules(void **state) {
  static const struct {
    const char *host;
    bool loopback, address;
  } rows[] = {{"localhost", true, true},
              {"Localhost:80", true, true},
              {"a.localhost", true, true},
              {".localhost", false, false},
              {"127.0.0.1:1", true, true},
              {"[::1]", true, true},
              {"10.0.0.1", false, true},
              {"[fe80::1]:2", false, true},
              {"a.example", false, false},
              {"notlocalhost", false, false},
              {"2130706433", false, false},
              {"0x7f000001", false, false},
              {"127.0.0.1.a.example", false, false}};
  static parameters set;
  (void)state;
  param_defaults(&set);
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    assert_true(host_allows(HOST_ANY, &set, rows[k].host));
    assert_int_equal(host_allows(HOST_LOOPBACK, &set, rows[k].host), rows[k].loopback);
    assert_int_equal(host_allows(HOST_ADDRESS, &set, rows[k].host), rows[k].address);
  }
}

static void test_configured(void **state) {
  static parameters set;
  (void)state;
  param_defaults(&set);
  snprintf(set.hosts, sizeof set.hosts, "a.example, B.example:80 10.0.0.1");
  snprintf(set.public_url, sizeof set.public_url, "https://c.example:1/x");
  static const char *const good[] = {"a.example:9", "A.EXAMPLE",  "b.example",
                                     "c.example",   "10.0.0.1:2", "a.example."};
  static const char *const bad[] = {"xa.example", "a.example.x", "c", "c.exampl", "example", "x"};
  for (size_t k = 0; k < sizeof good / sizeof *good; k++) {
    assert_true(host_allows(HOST_LOOPBACK, &set, good[k]));
  }
  for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
    assert_false(host_allows(HOST_LOOPBACK, &set, bad[k]));
  }
  snprintf(set.hosts, sizeof set.hosts, "*");
  assert_true(host_allows(HOST_LOOPBACK, &set, "anything"));
}

static void test_lists(void **state) {
  (void)state;
  assert_true(host_lists("https://a https://b", "https://b"));
  assert_true(host_lists(" https://a,https://b ", "https://a"));
  assert_true(host_lists("x *", "https://b"));
  assert_false(host_lists("https://a https://b", "https://"));
  assert_false(host_lists("https://a", "https://A"));
  assert_false(host_lists("", "https://a"));
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_rules),
                                     cmocka_unit_test(test_configured),
                                     cmocka_unit_test(test_lists)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
