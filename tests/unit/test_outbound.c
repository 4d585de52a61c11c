/* outbound.h: which hosts are allowed, which addresses are public; a call to nobody; to a host
 * whose name server does not answer. */
#include <dlfcn.h>
#include <netdb.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

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

/* ---- A name server that does not answer: libcurl asks it in threads of its own ---- */

static const char silent[] = "silent.example";

static struct {
  pthread_mutex_t lock;
  pthread_cond_t changed;
  bool is_open;           /* it answers: there is no such host */
  int asked, told, hasty; /* hasty: who was told before that, as nobody should wait so long */
} names = {.lock = PTHREAD_MUTEX_INITIALIZER, .changed = PTHREAD_COND_INITIALIZER};

static void wait_for_name(void) {
  struct timespec until;
  clock_gettime(CLOCK_REALTIME, &until);
  until.tv_sec += 100;
  pthread_mutex_lock(&names.lock);
  names.asked++;
  pthread_cond_broadcast(&names.changed);
  int late = 0;
  while (!names.is_open && late == 0) {
    late = pthread_cond_timedwait(&names.changed, &names.lock, &until);
  }
  names.hasty += late != 0;
  names.told++;
  pthread_cond_broadcast(&names.changed);
  pthread_mutex_unlock(&names.lock);
}

typedef int resolver(const char *name, const char *service, const struct addrinfo *hints,
                     struct addrinfo **found);

/* In the place of the C library's. */
int getaddrinfo(const char *name, const char *service, const struct addrinfo *hints,
                struct addrinfo **found) {
  if (name == NULL || strcmp(name, silent) != 0) {
    return ((resolver *)dlsym(RTLD_NEXT, "getaddrinfo"))(name, service, hints, found);
  }
  wait_for_name();
  return EAI_NONAME;
}

/* ---- Calls ---- */

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

static void await_asked(int count) {
  pthread_mutex_lock(&names.lock);
  while (names.asked < count) pthread_cond_wait(&names.changed, &names.lock);
  pthread_mutex_unlock(&names.lock);
}

static void let_names_be_told(void) {
  pthread_mutex_lock(&names.lock);
  names.is_open = true;
  pthread_cond_broadcast(&names.changed);
  while (names.told < names.asked) pthread_cond_wait(&names.changed, &names.lock);
  pthread_mutex_unlock(&names.lock);
}

/* One that runs out of time, one that is cancelled, one that ends with all: nothing waits for the
 * name server, nor does the loop. */
static void test_silent_names(void **state) {
  char url[64];
  loop *l = loop_new();
  outbound *o = outbound_new(l);
  waiting w = {.loop = l};
  (void)state;
  snprintf(url, sizeof url, "http://%s/", silent);
  const outbound_request brief = {.url = url, .seconds = 0.1, .most = 100};
  const outbound_request lasting = {.url = url, .seconds = 600, .most = 100};
  outbound_call *cancelled = outbound_start(o, &lasting, done, &w);
  assert_non_null(cancelled);
  assert_non_null(outbound_start(o, &lasting, done, &w));
  assert_non_null(outbound_start(o, &brief, done, &w));
  loop_run(l);
  assert_int_equal(w.reply.status, 0);
  assert_true(*w.reply.why != '\0');
  await_asked(3);
  outbound_cancel(cancelled);
  outbound_free(&o);
  loop_free(&l);
  assert_int_equal(names.hasty, 0);
  let_names_be_told();
  assert_int_equal(names.hasty, 0);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_allowed), cmocka_unit_test(test_nobody),
                                     cmocka_unit_test(test_cancel),
                                     cmocka_unit_test(test_silent_names)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
