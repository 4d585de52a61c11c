/* Memory runs out at every allocation of a whole answer, once or for good: the reply is a problem
 * that says so (or the result, if it could be had without), and nothing leaks (ASan). */
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "exhaust.h"
#include "inflate.h"
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

static void exhaust(const ask *question, bool lasting) {
  assert_in_range(exhaust_each(question, lasting, 0, 1), 1, MOST - 1);
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

#define APPLY(cloud)                                                     \
  "{\"inputs\":{\"cloud\":" cloud                                        \
  ",\"field\":\"x\"},\"outputs\":{\"value\":{\"format\":{\"mediaType\":" \
  "\"application/x-npy\"}},\"gradient\":{}}}"
#define POINTS "{\"points\":[[0],[1],[2],[3],[4],[5]]}"

/* Every form of a result, directly and from a stored one. */
static void test_forms(void **state) {
  const limits most = asking_limits();
  static const char body[] = APPLY(POINTS);
  static const media forms[] = {MEDIA_JSON, MEDIA_CBOR, MEDIA_CSV, MEDIA_VTP, MEDIA_MULTIPART};
  ask question = {.process = "apply", .body = body, .size = strlen(body), .limits = &most};
  reply stored;
  (void)state;
  question.work = IPC_RUN_STORED;
  exhaust(&question, false);
  answer(&question, &stored);
  for (size_t k = 0; k < sizeof forms / sizeof *forms; k++) {
    question.work = IPC_RUN;
    question.accept = media_wish(forms[k]);
    exhaust(&question, k % 2);
    const ask later = {.work = IPC_RENDER,
                       .process = "apply",
                       .body = stored.bytes,
                       .size = stored.size,
                       .accept = media_wish(forms[k]),
                       .limits = &most};
    exhaust(&later, k % 2);
  }
  free(stored.bytes);
}

static void fetch(void *context, const char *href, ask_fetched *out) {
  static const char csv[] = "x\n0\n1\n2\n3\n4\n5\n";
  (void)context, (void)href;
  *out = (ask_fetched){.status = 200, .media = MEDIA_CSV, .bytes = csv, .size = sizeof csv - 1};
}

static void keep(void *context, const char *type, const void *bytes, size_t size, ask_kept *out) {
  (void)context, (void)type, (void)bytes, (void)size;
  *out = (ask_kept){.status = 200, .href = "/data/1"};
}

/* References in, references out, and the check of a batch. */
static void test_references(void **state) {
  const limits most = asking_limits();
  static const struct {
    const char *process, *body;
    ipc_work work;
  } rows[] = {
      {"apply", APPLY("{\"href\":\"/data/1\"}"), IPC_RUN},
      {"apply", APPLY("{\"href\":\"data:text/csv;base64,MAoxCjIKMwo0\"}"), IPC_CHECK},
      {"echo",
       "{\"inputs\":{\"message\":\"m\"},\"outputs\":{\"message\":{\"transmissionMode\":"
       "\"reference\"}}}",
       IPC_RUN},
      {"batch",
       "{\"inputs\":{\"request\":{\"process\":\"apply\",\"inputs\":{\"field\":\"a*x\"}},"
       "\"parameters\":"
       "{\"a\":[1,2]},\"cloud\":{\"href\":\"/data/1\"}}}",
       IPC_CHECK},
      {"data", "[[1,2],[3,4]]", IPC_CHECK},
  };
  (void)state;
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    const ask question = {.work = rows[k].work,
                          .process = rows[k].process,
                          .body = rows[k].body,
                          .size = strlen(rows[k].body),
                          .limits = &most,
                          .calls = {.fetch = fetch, .keep = keep}};
    exhaust(&question, k % 2);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_json), cmocka_unit_test(test_packed),
                                     cmocka_unit_test(test_forms),
                                     cmocka_unit_test(test_references)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
