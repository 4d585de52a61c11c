/* outbound.h: which hosts are allowed, which addresses are public; a call to nobody. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <unistd.h>

#include "outbound.h"

static void test_allowed(void **state) {
  static const char hosts[] = "a.example, b.example:8443 [::1]:80";
  static const char *const good[] = {"http://a.example", "https://A.example/x?y",
                                     "http://a.example#", "https://b.example:8443/",
                                     "http://[::1]:80/"};
  static const char *const bad[] = {"",
                                    "/x",
                                    "ftp://a.example/",
                                    "http://b.example/",
                                    "http://a.example:80/",
                                    "http://a.example.evil.example/",
                                    "http://evil.example/a.example",
                                    "http://a.example@evil.example/",
                                    "http://evil.example\\\\a.example/",
                                    "http://evil.example?a.example",
                                    "http:///a.example",
                                    "http://a.example\n.evil.example/"};
  (void)state;
  for (size_t k = 0; k < sizeof good / sizeof *good; k++) {
    assert_true(outbound_allows(hosts, good[k]));
    assert_false(outbound_allows("", good[k]));
  }
  for (size_t k = 0; k < sizeof bad / sizeof *bad; k++)
    assert_false(outbound_allows(hosts, bad[k]));
}

typedef struct {
  loop *loop;
  outbound_reply reply;
} waiting;

static void done(void *context, const outbound_reply *reply) {
  waiting *w = context;
  w->reply = *reply;
  loop_stop(w->loop);
}

static outbound_reply call(const char *url, bool public_only) {
  waiting w = {.loop = loop_new()};
  outbound *o = outbound_new(w.loop);
  const outbound_request r = {.url = url, .seconds = 5, .most = 100, .public_only = public_only};
  assert_non_null(outbound_start(o, &r, done, &w));
  loop_run(w.loop);
  outbound_free(&o);
  loop_free(&w.loop);
  return w.reply;
}

/* Port 9 (discard) is closed nearly everywhere; whether it is does not matter to the second. */
static void test_nobody(void **state) {
  static const char *const private[] = {"http://127.0.0.1:9/",
                                        "http://[::1]:9/",
                                        "http://10.0.0.1:9/",
                                        "http://0.0.0.0:9/",
                                        "http://localhost:9/",
                                        "http://169.254.169.254/",
                                        "http://[::ffff:127.0.0.1]:9/",
                                        "http://192.168.1.1/",
                                        "http://[fe80::1]/",
                                        "http://[2002:7f00:1::]/"};
  (void)state;
  assert_int_equal(call("http://127.0.0.1:9/", false).status, 0);
  for (size_t k = 0; k < sizeof private / sizeof *private; k++) {
    const outbound_reply reply = call(private[k], true);
    assert_int_equal(reply.status, 0);
    assert_true(*reply.why != '\0');
    assert_int_equal(reply.fd, -1);
  }
}

static void test_cancel(void **state) {
  loop *l = loop_new();
  outbound *o = outbound_new(l);
  waiting w = {.loop = l};
  const outbound_request r = {.url = "http://127.0.0.1:9/", .seconds = 5, .most = 100};
  (void)state;
  outbound_cancel(outbound_start(o, &r, done, &w));
  (void)outbound_start(o, &r, done, &w); /* ended by the next line */
  outbound_free(&o);
  loop_free(&l);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_allowed), cmocka_unit_test(test_nobody),
                                     cmocka_unit_test(test_cancel)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
