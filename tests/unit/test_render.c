/* Results in every form: stored and rendered later they are, byte for byte, what a direct answer
 * gives; and each form says what the result document says. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "asking.h"

#define CLOUD "\"cloud\":{\"lattice\":{\"lower\":[0,0],\"upper\":[1,2],\"cells\":[3,2]}}"
#define APPLY "{\"inputs\":{" CLOUD ",\"field\":\"x*y+0.1\"}"

typedef struct {
  const char *process, *body;
} request;

/* No `report` among the outputs: it holds times. */
static const request requests[] = {
    {"echo", "{\"inputs\":{\"message\":\"hi\",\"pause\":0,\"values\":[1,2,3]}}"},
    {"echo", "{\"inputs\":{\"message\":\"hi\"},\"outputs\":{\"message\":{}},\"response\":\"raw\"}"},
    {"apply", APPLY ",\"outputs\":{\"value\":{},\"gradient\":{}}}"},
    {"apply", APPLY ",\"outputs\":{\"gradient\":{}},\"response\":\"raw\"}"},
    {"apply",
     APPLY ",\"outputs\":{\"value\":{},\"gradient\":{},\"laplacian\":{}},\"response\":\"raw\"}"},
    {"diagnose", "{\"inputs\":{" CLOUD "},\"outputs\":{\"neighbours\":{},\"number_density\":{},"
                 "\"artificial_velocity\":{},\"effective_diffusivity\":{},\"summary\":{}}}"},
    {"solve", "{\"inputs\":{" CLOUD ",\"diffusivity\":1,\"exact\":\"x\",\"boundary\":[{\"on\":"
              "\"boundary\",\"type\":\"dirichlet\",\"value\":\"x\"}]},\"outputs\":{\"solution\":{"
              "\"format\":{\"mediaType\":\"application/x-npy\"}},\"points\":{},\"norms\":{}}}"},
};
enum { REQUESTS = sizeof requests / sizeof *requests };

static reply ask_of(const request *q, ipc_work work, wishes accept) {
  static limits most;
  most = asking_limits();
  const ask question = {.work = work,
                        .process = q->process,
                        .body = q->body,
                        .size = strlen(q->body),
                        .accept = accept,
                        .limits = &most};
  reply r;
  answer(&question, &r);
  assert_non_null(r.bytes);
  return r;
}

static reply render_of(const reply *stored, const char *output, wishes accept) {
  static limits most;
  most = asking_limits();
  const ask question = {.work = IPC_RENDER,
                        .output = output,
                        .results_url = "http://here/jobs/1/results",
                        .body = stored->bytes,
                        .size = stored->size,
                        .accept = accept,
                        .limits = &most};
  reply r;
  answer(&question, &r);
  assert_non_null(r.bytes);
  return r;
}

static void assert_same(const reply *a, const reply *b) {
  assert_int_equal(a->status, b->status);
  assert_string_equal(a->type, b->type);
  assert_int_equal(a->size, b->size);
  assert_memory_equal(a->bytes, b->bytes, a->size);
}

/* Stored, then rendered, is the direct answer: in every form, refusals too. CBOR alone may pack the
 * same numbers otherwise, so there the values are compared. */
static void test_stored_is_direct(void **state) {
  (void)state;
  for (int k = 0; k < REQUESTS; k++) {
    reply stored = ask_of(&requests[k], IPC_RUN_STORED, (wishes){0});
    assert_int_equal(200, stored.status);
    for (int m = 0; m < MEDIA_COUNT; m++) {
      if (m == MEDIA_CBOR) continue;
      reply direct = ask_of(&requests[k], IPC_RUN, media_wish((media)m));
      reply later = render_of(&stored, "", media_wish((media)m));
      if (direct.status == 200 || direct.status == 406) assert_same(&direct, &later);
      assert_true(direct.status == 200 || direct.status == 406);
      if (m == MEDIA_JSON) assert_int_equal(200, direct.status);
      free(direct.bytes);
      free(later.bytes);
    }
    free(stored.bytes);
  }
}

/* What text the reply is. */
static void assert_text(const reply *r, int status, const char *type, const char *text) {
  assert_int_equal(status, r->status);
  if (type) assert_string_equal(type, r->type);
  assert_int_equal(strlen(text), r->size);
  assert_memory_equal(text, r->bytes, r->size);
}

static void test_csv(void **state) {
  (void)state;
  const request q = {"apply",
                     "{\"inputs\":{\"cloud\":{\"points\":[[0],[1],[2],[3.5]]},\"field\":\"2*x\"},"
                     "\"outputs\":{\"value\":{},\"laplacian\":{}}}"};
  reply stored = ask_of(&q, IPC_RUN_STORED, (wishes){0});
  reply all = render_of(&stored, NULL, media_wish(MEDIA_CSV));
  reply one = render_of(&stored, "value", media_wish(MEDIA_CSV));
  asked json = {.raw = render_of(&stored, "value", (wishes){0})};
  assert_non_null(strstr((char *)all.bytes, "x,value,laplacian\r\n0,"));
  assert_non_null(strstr((char *)one.bytes, "x,value\r\n0,"));
  assert_string_equal("application/json", json.raw.type);
  assert_int_equal('[', ((char *)json.raw.bytes)[0]);
  double x[4], value[4];
  assert_int_equal(
      8, sscanf((char *)one.bytes, "x,value\r\n%lf,%lf\r\n%lf,%lf\r\n%lf,%lf\r\n%lf,%lf\r\n", &x[0],
                &value[0], &x[1], &value[1], &x[2], &value[2], &x[3], &value[3]));
  assert_true(x[3] == 3.5 && value[0] >= -1 && value[3] <= 8);
  free(stored.bytes);
  free(all.bytes);
  free(one.bytes);
  asked_clear(&json);
}

static void test_npy(void **state) {
  (void)state;
  const request q = {"echo",
                     "{\"inputs\":{\"message\":\"hi\",\"values\":[1,2,3]},"
                     "\"outputs\":{\"values\":{}},\"response\":\"raw\"}"};
  reply r = ask_of(&q, IPC_RUN, media_wish(MEDIA_NPY));
  const char *bytes = r.bytes;
  const double expected[] = {1, 2, 3};
  assert_int_equal(200, r.status);
  assert_string_equal("application/x-npy", r.type);
  assert_int_equal(128 + sizeof expected, r.size);
  assert_memory_equal("\x93NUMPY\1\0v\0{'descr': '<f8', 'fortran_order': False, 'shape': (3,), }",
                      bytes, 67);
  assert_int_equal('\n', bytes[127]);
  assert_memory_equal(expected, bytes + 128, sizeof expected);
  free(r.bytes);
}

static void test_multipart(void **state) {
  (void)state;
  const request q = {
      "echo",
      "{\"inputs\":{\"message\":\"hi\",\"pause\":0.5},\"outputs\":{\"message\":{},\"pause\":{"
      "\"transmissionMode\":\"reference\"}},\"response\":\"raw\"}"};
  reply stored = ask_of(&q, IPC_RUN_STORED, (wishes){0});
  reply parts = render_of(&stored, "", media_wish(MEDIA_MULTIPART));
  reply document = render_of(&stored, "", (wishes){0});
  assert_text(&parts, 200,
              "multipart/related; boundary=part-of-a-result-5ca77e6d; type=\"application/json\"",
              "--part-of-a-result-5ca77e6d\r\nContent-Type: application/json\r\n"
              "Content-ID: <message>\r\nContent-Length: 4\r\n\r\n\"hi\"\r\n"
              "--part-of-a-result-5ca77e6d\r\nContent-Type: application/json\r\n"
              "Content-ID: <pause>\r\nContent-Location: http://here/jobs/1/results/pause\r\n"
              "\r\n\r\n--part-of-a-result-5ca77e6d--\r\n");
  assert_text(&document, 200, "application/json",
              "{\"message\":\"hi\",\"pause\":{\"href\":\"http://here/jobs/1/results/pause\","
              "\"type\":\"application/json\"}}");
  free(stored.bytes);
  free(parts.bytes);
  free(document.bytes);
}

static void test_links(void **state) {
  (void)state;
  const request q = {"echo",
                     "{\"inputs\":{\"message\":\"hi\"},\"outputs\":{\"message\":{"
                     "\"transmissionMode\":\"reference\"}},\"response\":\"raw\"}"};
  reply stored = ask_of(&q, IPC_RUN_STORED, (wishes){0});
  reply links = render_of(&stored, "", (wishes){0});
  assert_text(&links, 204, "",
              "<http://here/jobs/1/results/message>; rel=\"message\"; type=\"application/json\"\n");
  free(stored.bytes);
  free(links.bytes);
}

static void keep(void *context, const char *type, const void *bytes, size_t size, ask_kept *out) {
  int *calls = context;
  assert_string_equal("application/json", type);
  assert_int_equal(4, size);
  assert_memory_equal("\"hi\"", bytes, 4);
  *out = (ask_kept){
      .status = *calls == 0 ? 200 : 507, .href = "/data/abc", .detail = "the disk is full"};
  ++*calls;
}

/* A direct answer keeps what is wanted by reference. */
static void test_kept(void **state) {
  (void)state;
  static const char body[] =
      "{\"inputs\":{\"message\":\"hi\"},\"outputs\":{\"message\":{"
      "\"transmissionMode\":\"reference\"}}}";
  const limits most = asking_limits();
  int calls = 0;
  const ask question = {.process = "echo",
                        .body = body,
                        .size = strlen(body),
                        .limits = &most,
                        .calls = {.context = &calls, .keep = keep}};
  reply r;
  answer(&question, &r);
  assert_text(&r, 200, "application/json",
              "{\"message\":{\"href\":\"/data/abc\",\"type\":\"application/json\"}}");
  free(r.bytes);
  answer(&question, &r);
  assert_int_equal(507, r.status);
  assert_int_equal(2, calls);
  free(r.bytes);
}

static void test_refusals(void **state) {
  (void)state;
  reply stored = ask_of(&requests[0], IPC_RUN_STORED, (wishes){0});
  const struct {
    const char *output;
    media accept;
    int status;
  } rows[] = {{"", MEDIA_VTP, 406},       {"", MEDIA_NPY, 406},        {"message", MEDIA_NPY, 406},
              {"values", MEDIA_NPY, 200}, {"message", MEDIA_CSV, 406}, {"massage", MEDIA_JSON, 404},
              {"", MEDIA_OCTETS, 406},    {"", MEDIA_MULTIPART, 200}};
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    reply r = render_of(&stored, rows[k].output, media_wish(rows[k].accept));
    assert_int_equal(rows[k].status, r.status);
    free(r.bytes);
  }
  free(stored.bytes);
  const reply foreign = {.bytes = "\xa1\x61\x61\x01", .size = 4};
  reply r = render_of(&foreign, "", (wishes){0});
  assert_int_equal(400, r.status);
  free(r.bytes);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_stored_is_direct),
      cmocka_unit_test(test_csv),
      cmocka_unit_test(test_npy),
      cmocka_unit_test(test_multipart),
      cmocka_unit_test(test_links),
      cmocka_unit_test(test_kept),
      cmocka_unit_test(test_refusals),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
