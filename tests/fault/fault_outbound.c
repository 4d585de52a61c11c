/* Each allocation of a call to another service fails, libcurl's and ours: the call is refused or
 * ends, with the reply or with a reason, and the next one succeeds; none is forgotten. */
#include <arpa/inet.h>
#include <netinet/in.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>
#include <curl/curl.h>

#include "outbound.h"
#include "scarce.h"

enum { CALLS = 2 };

typedef struct {
  loop *loop;
  outbound *outbound;
  pid_t server;
  char url[64];
  int waiting, answered, scarce;
} bench;

/* ---- Who is called: a process of its own, whose memory does not run out ---- */

static void serve(int listening) {
  static const char reply[] = "HTTP/1.1 200 OK\r\nContent-Length: 5\r\n\r\nhello";
  char request[4096];
  prctl(PR_SET_PDEATHSIG, SIGKILL); /* nobody waits for its output when the test crashes */
  signal(SIGPIPE, SIG_IGN);         /* who calls may have given up */
  for (;;) {
    const int fd = accept(listening, NULL, NULL);
    if (fd < 0) continue;
    if (read(fd, request, sizeof request) > 0) (void)!write(fd, reply, sizeof reply - 1);
    close(fd);
  }
}

static int begin(void **state) {
  static bench b;
  struct sockaddr_in address = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
  socklen_t length = sizeof address;
  const int listening = socket(AF_INET, SOCK_STREAM, 0);
  if (bind(listening, (struct sockaddr *)&address, length) != 0) return -1;
  if (listen(listening, 64) != 0) return -1;
  if (getsockname(listening, (struct sockaddr *)&address, &length) != 0) return -1;
  snprintf(b.url, sizeof b.url, "http://127.0.0.1:%d/x", ntohs(address.sin_port));
  b.server = fork();
  if (b.server == 0) serve(listening);
  close(listening);
  b.loop = loop_new();
  b.outbound = outbound_new(b.loop);
  *state = &b;
  return b.server > 0 && b.loop != NULL && b.outbound != NULL ? 0 : -1;
}

static int end(void **state) {
  bench *b = *state;
  outbound_free(&b->outbound);
  loop_free(&b->loop);
  kill(b->server, SIGKILL);
  return waitpid(b->server, NULL, 0) == b->server ? 0 : -1;
}

/* ---- Calls ---- */

static void done(void *context, const outbound_reply *reply) {
  bench *b = context;
  assert_true(reply->status == 200 || (reply->status == 0 && *reply->why != '\0'));
  b->answered += reply->status == 200 && reply->size == 5;
  b->scarce += reply->scarce;
  if (reply->fd >= 0) close(reply->fd);
  if (--b->waiting == 0) loop_stop(b->loop);
}

/* How many of two calls at a time are answered; the others end or are refused. */
static int answered(bench *b) {
  const outbound_request r = {.url = b->url, .seconds = 600, .most = 100};
  b->waiting = b->answered = 0;
  for (int k = 0; k < CALLS; k++) {
    if (outbound_start(b->outbound, &r, done, b) != NULL) b->waiting++;
  }
  if (b->waiting > 0) loop_run(b->loop);
  return b->answered;
}

static void fail_each(bench *b, bool lasting) {
  int64_t granted = 0;
  int less = 0;
  b->scarce = 0;
  for (bool failed = true; failed; granted++) {
    scarce_after(granted, lasting);
    const int now = answered(b);
    failed = scarce_end();
    if (!failed) assert_int_equal(now, CALLS);
    less += now < CALLS;
    const int scarce = b->scarce;
    assert_int_equal(answered(b), CALLS); /* with memory again */
    assert_int_equal(b->scarce, scarce);
  }
  assert_true(granted > 100); /* libcurl's own count */
  assert_true(less > 10);
  assert_true(b->scarce > 10); /* not all: libcurl takes some for a connection that cannot be had */
}

static void test_one(void **state) {
  fail_each(*state, false);
}

static void test_all_after_it(void **state) {
  fail_each(*state, true);
}

/* The C library's would not come through our malloc. */
static char *copy(const char *text) {
  const size_t size = strlen(text) + 1;
  char *made = malloc(size);
  return made != NULL ? memcpy(made, text, size) : NULL;
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_one),
                                     cmocka_unit_test(test_all_after_it)};
  if (curl_global_init_mem(CURL_GLOBAL_DEFAULT, malloc, free, realloc, copy, calloc) != CURLE_OK) {
    return 1;
  }
  const int failures = cmocka_run_group_tests(tests, begin, end);
  curl_global_cleanup();
  return failures;
}
