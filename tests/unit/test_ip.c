/* ip.h: whose addresses they are. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <arpa/inet.h>
#include <netinet/in.h>

#include "ip.h"

static ip of(const char *text) {
  ip a;
  assert_true(ip_read(&a, text));
  return a;
}

static void test_loopback(void **state) {
  static const char *const own[] = {"127.0.0.1", "127.255.1.2", "::1", "::ffff:127.0.0.1"};
  static const char *const others[] = {
      "128.0.0.1", "0.0.0.0", "10.0.0.1", "::", "::2", "fe80::1", "::ffff:10.0.0.1"};
  (void)state;
  for (size_t k = 0; k < sizeof own / sizeof *own; k++) {
    const ip a = of(own[k]);
    assert_true(ip_is_loopback(&a));
  }
  for (size_t k = 0; k < sizeof others / sizeof *others; k++) {
    const ip a = of(others[k]);
    assert_false(ip_is_loopback(&a));
  }
}

static void test_no_address(void **state) {
  static const char *const texts[] = {"", "a", "127.1", "1.2.3", "0x7f.0.0.1", "[::1]", "1.2.3.4 "};
  ip a;
  (void)state;
  for (size_t k = 0; k < sizeof texts / sizeof *texts; k++) assert_false(ip_read(&a, texts[k]));
  assert_false(ip_of(&a, &(struct sockaddr){.sa_family = AF_UNIX}));
}

static void test_clients(void **state) {
  static const struct {
    const char *a, *b;
    bool same;
  } rows[] = {{"10.0.0.1", "10.0.0.1", true},
              {"10.0.0.1", "10.0.0.2", false},
              {"10.0.0.1", "::ffff:10.0.0.1", true},
              {"2001:db8::1", "2001:db8::ffff:2", true},
              {"2001:db8::1", "2001:db8:0:1::1", false}};
  (void)state;
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    const ip a = of(rows[k].a), b = of(rows[k].b);
    assert_int_equal(ip_is_same_client(&a, &b), rows[k].same);
  }
}

static void test_sockets(void **state) {
  struct sockaddr_in four = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(0x0a000001)};
  struct sockaddr_in6 six = {.sin6_family = AF_INET6, .sin6_addr = IN6ADDR_LOOPBACK_INIT};
  char text[64];
  ip a;
  const ip ten = of("10.0.0.1");
  (void)state;
  assert_true(ip_of(&a, (struct sockaddr *)&four));
  assert_memory_equal(&a, &ten, sizeof a);
  assert_true(ip_of(&a, (struct sockaddr *)&six));
  assert_true(ip_is_loopback(&a));
  ip_show((struct sockaddr *)&four, text, sizeof text);
  assert_string_equal(text, "10.0.0.1");
  ip_show((struct sockaddr *)&six, text, sizeof text);
  assert_string_equal(text, "::1");
  ip_show(&(struct sockaddr){.sa_family = AF_UNIX}, text, sizeof text);
  assert_string_equal(text, "local");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_loopback), cmocka_unit_test(test_no_address),
      cmocka_unit_test(test_clients), cmocka_unit_test(test_sockets)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
