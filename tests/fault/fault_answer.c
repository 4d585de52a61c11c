/* Memory runs out at every allocation of a whole answer, once or for good: the reply is a problem
 * that says so (or the result, if it could be had without), and nothing leaks (ASan). */
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "inflate.h"
#include "scarce.h"
#include "unit/asking.h"

typedef struct {
  const char *process, *body;
} request;

static const request requests[] = {
    {"echo", "{\"inputs\":{\"message\":\"hi\",\"values\":[1,2]}}"},
    {"echo", "{\"inputs\":{\"pause\":\"long\"}}"},
    {"solve",
     "{\"inputs\":{\"cloud\":{\"lattice\":{\"lower\":[0,0],\"upper\":[1,1],\"cells\":[4,4]}},"
     "\"parameters\":"
     "{\"a\":1},\"diffusivity\":\"a\",\"velocity\":[1,\"y\"],\"boundary\":[{\"on\":\"left\","
     "\"type\":"
     "\"dirichlet\",\"value\":\"y\"},{\"on\":[14,19],\"type\":\"neumann\",\"value\":1}],\"exact\":"
     "\"x\"}}"},
    {"solve",
     "{\"inputs\":{\"cloud\":{\"points\":[[0],[1],[2],[3],[4],[5]],\"groups\":{\"ends\":[0,5]},"
     "\"normals\":"
     "{\"ends\":[[-1],[1]]}},\"diffusivity\":\"1+t\",\"initial\":0,\"source\":[1,2,3,4,5,6],"
     "\"boundary\":["
     "{\"on\":\"ends\",\"type\":\"robin\",\"value\":\"t\",\"coefficient\":\"2\"}],\"time\":{"
     "\"end\":1,"
     "\"step\":0.25,\"save\":[0.5,1]}}}"},
    {"solve",
     "{\"inputs\":{\"cloud\":{\"lattice\":{\"lower\":[0,0],\"upper\":[1,1],\"cells\":[4,4]}},"
     "\"operator\":{\"upwind\":\"limited\"},\"diffusivity\":0.01,\"velocity\":[1,2],\"boundary\":["
     "{\"on\":\"boundary\",\"type\":\"dirichlet\",\"value\":\"y\"}]}}"},
    {"solve",
     "{\"inputs\":{\"cloud\":{\"points\":[[0],[1],[2],[3],[4],[5]]},\"operator\":{\"upwind\":"
     "\"limited\"},\"diffusivity\":0.01,\"velocity\":[1],\"initial\":0,\"boundary\":[{\"on\":[0,5],"
     "\"type\":\"dirichlet\",\"value\":1}],\"time\":{\"end\":1,\"step\":0.25,\"method\":"
     "\"crank-nicolson\"}}}"},
    {"apply",
     "{\"inputs\":{\"cloud\":{\"points\":[[0],[1],[2],[3],[4],[5]]},\"field\":\"x\",\"exact_"
     "gradient\":[1]}}"},
    {"diagnose", "{\"inputs\":{\"cloud\":{\"points\":[[0,0],[1,0],[0,1],[1,1]]}}}"},
    {"study", "{\"inputs\":{\"case\":\"three-point\",\"parameters\":{\"alpha\":[0.1,0.2]}}}"},
    {"study",
     "{\"inputs\":{\"case\":\"smith-hutton\",\"cells\":[3],\"parameters\":{\"seeds\":2}}}"},
    {"study", "{\"inputs\":{\"case\":\"gartland\",\"cells\":[3,-1]}}"},
};
enum { REQUESTS = sizeof requests / sizeof *requests, MOST = 2000 };

/* One answer with scarce memory; false when there was enough. */
static bool runs_out(const ask *question, int expected, int64_t granted, bool lasting) {
  reply r;
  scarce_after(granted, lasting);
  answer(question, &r);
  bool failed = scarce_end();
  bool is_well =
      r.status == expected || r.status == 413 || r.status == 422 || (r.status == 500 && !r.bytes);
  if (!is_well || (!failed && r.status != expected)) {
    fail_msg("%s, allocation %lld: got %d, needs %d, 413 or 422: %.*s", question->process,
             (long long)granted, r.status, expected, r.bytes ? (int)r.size : 4,
             r.bytes ? (char *)r.bytes : "none");
  }
  free(r.bytes);
  return failed;
}

static void exhaust(const ask *question, bool lasting) {
  reply r;
  answer(question, &r);
  int expected = r.status;
  free(r.bytes);
  int64_t n = 0;
  while (n < MOST && runs_out(question, expected, n, lasting)) n++;
  assert_in_range(n, 1, MOST - 1);
}

static void test_json(void **state) {
  const limits most = asking_limits();
  (void)state;
  for (int k = 0; k < 2 * REQUESTS; k++) {
    const request *q = &requests[k / 2];
    const ask question = {
        .process = q->process, .body = q->body, .size = strlen(q->body), .limits = &most};
    exhaust(&question, k % 2);
  }
}

/* The same in CBOR, compressed both ways. */
static void test_packed(void **state) {
  const limits most = asking_limits();
  (void)state;
  for (int k = 0; k < 2 * REQUESTS; k++) {
    const request *q = &requests[k / 2];
    const coding c = k % 2 ? CODING_GZIP : CODING_ZSTD;
    size_t size, packed_size;
    void *packed, *cbor = cbor_of(q->body, &size);
    assert_int_equal(INFLATE_OK, deflate_bytes(c, cbor, size, &packed, &packed_size));
    const ask question = {.process = q->process,
                          .body = packed,
                          .size = packed_size,
                          .content = MEDIA_CBOR,
                          .content_coding = c,
                          .accept = media_wish(MEDIA_CBOR),
                          .accept_coding = c,
                          .limits = &most};
    exhaust(&question, false);
    free(packed);
    free(cbor);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_json), cmocka_unit_test(test_packed)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
