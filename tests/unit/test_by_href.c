/* Inputs by reference: the same answer as with the value in the request; what cannot be had is a
 * complaint that points to its href. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "asking.h"
#include "inflate.h"

/* What the caller of an answer has to give. */
typedef struct {
  const char *href;
  int status;
  media media;
  const void *bytes;
  size_t size;
} thing;

static const char npy[] =
    "\x93NUMPY\1\0v\0{'descr': '<f8', 'fortran_order': False, 'shape': (4, 1), }"
    "                                                          \n"
    "\0\0\0\0\0\0\0\0\0\0\0\0\0\0\xf0\x3f\0\0\0\0\0\0\0\x40\0\0\0\0\0\0\x0c\x40";

#define TEXT(t) (t), sizeof(t) - 1
static const thing things[] = {
    {"/data/points", 200, MEDIA_JSON, TEXT("[[0],[1],[2],[3.5]]")},
    {"/data/cloud", 200, MEDIA_JSON, TEXT("{\"points\":[[0],[1],[2],[3.5]]}")},
    {"/data/npy", 200, MEDIA_NPY, TEXT(npy)},
    {"/data/csv", 200, MEDIA_CSV, TEXT("x\r\n0\r\n1\r\n2\r\n3.5\r\n")},
    {"/data/field", 200, MEDIA_JSON, TEXT("[0,2,4,7]")},
    {"/data/loop", 200, MEDIA_JSON, TEXT("{\"href\":\"/data/loop\"}")},
    {"/data/bad", 200, MEDIA_JSON, TEXT("[0,1")},
    {"/data/octets", 200, MEDIA_OCTETS, TEXT("abc")},
    {"/data/gone", 410, MEDIA_JSON, NULL, 0},
};

static int fetches, releases;

static void fetch(void *context, const char *href, ask_fetched *out) {
  (void)context;
  fetches++;
  snprintf(out->detail, sizeof out->detail, "%s is not here", href);
  for (size_t k = 0; k < sizeof things / sizeof *things; k++) {
    if (strcmp(things[k].href, href) != 0) continue;
    out->status = things[k].status;
    out->bytes = things[k].bytes;
    out->size = things[k].size;
    out->media = things[k].media;
  }
}

static void release(void *context, ask_fetched *out) {
  (void)context, (void)out;
  releases++;
}

static asked ask_by_href(ipc_work work, const char *body) {
  static limits most;
  most = asking_limits();
  fetches = releases = 0;
  const ask question = {.work = work,
                        .process = "apply",
                        .body = body,
                        .size = strlen(body),
                        .limits = &most,
                        .calls = {.fetch = fetch, .release = release}};
  asked a = {0};
  if (work == IPC_RUN) return ask_all(&question);
  answer(&question, &a.raw);
  return a;
}

#define REQUEST(cloud, field) \
  "{\"inputs\":{\"cloud\":" cloud ",\"field\":" field "},\"outputs\":{\"laplacian\":{}}}"
#define HREF(href) "{\"href\":\"" href "\"}"

static void test_values(void **state) {
  (void)state;
  static const char *const bodies[] = {
      REQUEST("{\"points\":[[0],[1],[2],[3.5]]}", "[0,2,4,7]"), /* the one to compare with */
      REQUEST(HREF("/data/cloud"), "[0,2,4,7]"),
      REQUEST(HREF("/data/points"), HREF("/data/field")),
      REQUEST(HREF("/data/npy"), HREF("/data/field")),
      REQUEST(HREF("/data/csv"), "\"2*x\""),
      REQUEST("{\"points\":" HREF("/data/points") "}", "{\"value\":" HREF("/data/field") "}"),
      REQUEST("{\"value\":" HREF("/data/npy") "}",
              "{\"href\":\"/data/field\",\"type\":\"application/json\",\"rel\":\"x\"}"),
      REQUEST(HREF("data:application/json,%7B%22points%22:[[0],[1],[2],[3.5]]}"),
              HREF("data:;base64,WzAsMiw0LDdd")),
      REQUEST("{\"value\":\"W1swXSxbMV0sWzJdLFszLjVdXQ==\",\"encoding\":\"base64\","
              "\"mediaType\":\"application/json\"}",
              "\"2*x\""),
      REQUEST(HREF("data:text/csv;header=present,x%0a0%0a1%0a2%0a3.5"),
              HREF("DATA:text/csv,0%0A2%0A4%0A7")),
  };
  asked plain = ask_by_href(IPC_RUN, bodies[0]);
  assert_int_equal(200, plain.raw.status);
  for (size_t k = 1; k < sizeof bodies / sizeof *bodies; k++) {
    asked a = ask_by_href(IPC_RUN, bodies[k]);
    if (a.raw.status != 200) fail_msg("%s: %.*s", bodies[k], (int)a.raw.size, (char *)a.raw.bytes);
    assert_memory_equal(numbers_at(plain.root, "/laplacian", 4),
                        numbers_at(a.root, "/laplacian", 4), 4 * sizeof(double));
    assert_int_equal(fetches, releases);
    asked_clear(&a);
  }
  asked_clear(&plain);
}

/* One href, one fetch, however often it stands. */
static void test_once(void **state) {
  (void)state;
  asked a =
      ask_by_href(IPC_RUN, "{\"inputs\":{\"cloud\":" HREF("/data/npy") ",\"field\":" HREF(
                               "/data/field") ",\"exact_laplacian\":" HREF("/data/field") "}}");
  assert_int_equal(200, a.raw.status);
  assert_int_equal(2, fetches);
  asked_clear(&a);
}

static void test_complaints(void **state) {
  (void)state;
  static const struct {
    const char *body, *culprits, *word;
  } rows[] = {
      {REQUEST(HREF("/data/gone"), "1"), "/inputs/cloud/href", "is not here"},
      {REQUEST(HREF("/data/none"), HREF("/data/none")), "/inputs/cloud/href /inputs/field/href",
       "is not here"},
      {REQUEST(HREF("/data/bad"), "1"), "/inputs/cloud/href", "cannot be read"},
      {REQUEST(HREF("/data/octets"), "1"), "/inputs/cloud/href", "cannot be read"},
      {REQUEST(HREF("/data/loop"), "1"), "/inputs/cloud/href", "unknown member"},
      {REQUEST("{\"points\":" HREF("/data/none") "}", "1"), "/inputs/cloud/points/href",
       "is not here"},
      {REQUEST(HREF("data:nothing"), "1"), "/inputs/cloud/href", "no comma"},
      {REQUEST(HREF("data:image/png,1"), "1"), "/inputs/cloud/href", "media type"},
      {REQUEST(HREF("data:;base64,*"), "1"), "/inputs/cloud/href", "no base64"},
      {REQUEST(HREF("/data/csv"), HREF("/data/points")), "/inputs/field", ""},
      {REQUEST("{\"value\":\"*\",\"encoding\":\"base64\",\"mediaType\":\"text/csv\"}", "1"),
       "/inputs/cloud/value", "no base64"},
      {REQUEST("{\"value\":\"Wzs=\",\"encoding\":\"base64\",\"mediaType\":\"application/json\"}",
               "1"),
       "/inputs/cloud/value", "cannot be read"},
      {REQUEST("{\"href\":1}", "1"), "/inputs/cloud/href", ""},
  };
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    char room[512];
    asked a = ask_by_href(IPC_RUN, rows[k].body);
    assert_int_equal(400, a.raw.status);
    assert_string_equal(rows[k].culprits, culprits_of(&a, room, sizeof room));
    if (!strstr(at_pointer(a.root, "/detail")->text, rows[k].word)) {
      fail_msg("%.*s", (int)a.raw.size, (char *)a.raw.bytes);
    }
    asked_clear(&a);
  }
}

static void test_nobody_fetches(void **state) {
  (void)state;
  asked a = ask_json("apply", REQUEST(HREF("/data/csv"), "1"));
  assert_int_equal(400, a.raw.status);
  asked_clear(&a);
}

static void assert_frame(const char **at, ipc_frame_kind kind, const char *text) {
  ipc_frame head;
  memcpy(&head, *at, sizeof head);
  assert_int_equal(kind, head.kind);
  assert_int_equal(strlen(text), head.size);
  assert_memory_equal(text, *at + sizeof head, (size_t)head.size);
  *at += sizeof head + (size_t)head.size;
}

/* What a check tells whoever will store the request. */
static void test_frames(void **state) {
  (void)state;
  asked a = ask_by_href(IPC_CHECK,
                        "{\"inputs\":{\"cloud\":" HREF("/data/npy") ",\"field\":" HREF(
                            "data:,1") "},\"subscriber\":{\"successUri\":\"http://a/\","
                                       "\"failedUri\":\"https://b/?c\"}}");
  assert_int_equal(200, a.raw.status);
  assert_int_equal(4, a.raw.points);
  assert_true(a.raw.memory_bytes > 0);
  const char *at = a.raw.bytes;
  assert_frame(&at, IPC_FRAME_SUCCESS, "http://a/");
  assert_frame(&at, IPC_FRAME_FAILED, "https://b/?c");
  assert_frame(&at, IPC_FRAME_HREF, "/data/npy");
  assert_int_equal(a.raw.size, at - (char *)a.raw.bytes);
  asked_clear(&a);
  a = ask_by_href(IPC_CHECK, REQUEST("{\"points\":[[0],[1],[2]]}", "1"));
  assert_int_equal(200, a.raw.status);
  assert_int_equal(0, a.raw.size);
  assert_non_null(a.raw.bytes);
  asked_clear(&a);
}

#define CHILD "{\"process\":\"apply\",\"inputs\":{\"field\":\"a*x\"},\"outputs\":{\"gradient\":{}}}"

static asked ask_batch(ipc_work work, const char *body) {
  static limits most;
  most = asking_limits();
  fetches = releases = 0;
  const ask question = {.work = work,
                        .process = "batch",
                        .body = body,
                        .size = strlen(body),
                        .limits = &most,
                        .calls = {.fetch = fetch, .release = release}};
  asked a = {0};
  answer(&question, &a.raw);
  return a;
}

/* The next frame must be a child; its body runs by itself. */
static void assert_child(const char **at, const char *process, double last) {
  static limits most;
  most = asking_limits();
  ipc_frame head;
  memcpy(&head, *at, sizeof head);
  assert_int_equal(IPC_FRAME_CHILD, head.kind);
  assert_string_equal(process, head.process);
  assert_int_equal(4, head.points);
  assert_true(head.memory_bytes > 0);
  const ask question = {.process = head.process,
                        .body = *at + sizeof head,
                        .size = (size_t)head.size,
                        .content = MEDIA_CBOR,
                        .limits = &most,
                        .calls = {.fetch = fetch, .release = release}};
  asked a = ask_all(&question);
  assert_int_equal(200, a.raw.status);
  const double got = numbers_at(a.root, "/gradient", 4)[3];
  assert_true(got > last - 1e-12 && got < last + 1e-12);
  assert_null(at_pointer(a.root, "/value"));
  asked_clear(&a);
  *at += sizeof head + (size_t)head.size;
}

/* A table and a list are split into the same children; a shared cloud is fetched once. */
static void test_batch(void **state) {
  (void)state;
  static const char *const bodies[] = {
      "{\"inputs\":{\"request\":" CHILD
      ",\"parameters\":{\"a\":[1,2]},\"cloud\":" HREF("/data/npy") "}}",
      "{\"inputs\":{\"requests\":[{\"process\":\"apply\",\"inputs\":{\"field\":\"x\"},\"outputs\":{"
      "\"gradient\":{}}},{\"process\":\"apply\",\"inputs\":{\"field\":\"2*x\",\"cloud\":" HREF(
          "/data/npy") "},\"outputs\":{\"gradient\":{}}}],\"cloud\":" HREF("/data/npy") "}}"};
  for (int k = 0; k < 2; k++) {
    asked a = ask_batch(IPC_CHECK, bodies[k]);
    if (a.raw.status != 200) fail_msg("%.*s", (int)a.raw.size, (char *)a.raw.bytes);
    assert_int_equal(1, fetches);
    const char *at = a.raw.bytes, *end = at + a.raw.size;
    assert_frame(&at, IPC_FRAME_HREF, "/data/npy");
    assert_child(&at, "apply", 1);
    assert_child(&at, "apply", 2);
    assert_ptr_equal(end, at);
    asked_clear(&a);
  }
}

static void test_batch_complaints(void **state) {
  (void)state;
  static const struct {
    const char *body, *pointer;
  } rows[] = {
      {"{\"inputs\":{}}", "/inputs"},
      {"{\"inputs\":{\"requests\":[]}}", "/inputs/requests"},
      {"{\"inputs\":{\"requests\":[1]}}", "/inputs/requests"},
      {"{\"inputs\":{\"requests\":[{\"process\":\"batch\"}]}}", "/inputs/requests/0/process"},
      {"{\"inputs\":{\"requests\":[{\"process\":\"echo\",\"inputs\":{\"message\":\"m\"}},"
       "{\"process\":\"echo\",\"inputs\":{\"message\":1}}]}}",
       "/inputs/requests/1/inputs/message"},
      {"{\"inputs\":{\"request\":" CHILD "}}", "/inputs/parameters"},
      {"{\"inputs\":{\"request\":" CHILD ",\"parameters\":{\"a\":[1],\"b\":[1,2]}}}",
       "/inputs/parameters/b"},
      {"{\"inputs\":{\"request\":" CHILD ",\"parameters\":{\"a\":[1]},\"requests\":[1]}}",
       "/inputs/request"},
      {"{\"inputs\":{\"request\":" CHILD
       ",\"parameters\":{\"a\":[1]},\"cloud\":" HREF("/data/none") "}}",
       "/inputs/request/inputs/cloud/href"},
  };
  for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
    asked a = ask_batch(IPC_CHECK, rows[k].body);
    char pointer[128];
    snprintf(pointer, sizeof pointer, "\"pointer\":\"%s\"", rows[k].pointer);
    assert_int_equal(400, a.raw.status);
    if (!memmem(a.raw.bytes, a.raw.size, pointer, strlen(pointer))) {
      fail_msg("%zu: %.*s", k, (int)a.raw.size, (char *)a.raw.bytes);
    }
    asked_clear(&a);
  }
}

static void test_check_refuses(void **state) {
  (void)state;
  asked a = ask_by_href(IPC_CHECK, REQUEST("{\"points\":[[0],[1],[\"2\"]]}", "1"));
  assert_int_equal(400, a.raw.status);
  asked_clear(&a);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_values),     cmocka_unit_test(test_once),
      cmocka_unit_test(test_complaints), cmocka_unit_test(test_nobody_fetches),
      cmocka_unit_test(test_frames),     cmocka_unit_test(test_check_refuses),
      cmocka_unit_test(test_batch),      cmocka_unit_test(test_batch_complaints),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
