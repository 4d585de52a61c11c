/* Whole requests: what the processes compute, in every form of body and reply. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "asking.h"
#include "inflate.h"

static const char *const LINEAR =
    "{\"inputs\": {\"cloud\": {\"lattice\": {\"lower\": [0, 0], \"upper\": [1, 1], \"cells\": [8, "
    "8],"
    " \"jitter\": 0.3, \"seed\": 7}}, \"parameters\": {\"k\": 2}, \"velocity\": [\"1\", \"y\"],"
    " \"diffusivity\": 0.1, \"reaction\": 1, \"source\": \"k*(1 + y) + k*(x + y)\","
    " \"boundary\": [{\"on\": \"boundary\", \"type\": \"dirichlet\", \"value\": \"k*(x + y)\"}],"
    " \"exact\": \"k*(x + y)\"}}";

static asked well(const char *process, const char *body) {
  asked a = ask_json(process, body);
  if (a.raw.status != 200) fail_msg("%d: %.*s", a.raw.status, (int)a.raw.size, (char *)a.raw.bytes);
  return a;
}

static void test_echo(void **state) {
  asked a = well(
      "echo", "{\"inputs\":{\"message\":\"h\\u00e4 \\\"1\\\"\",\"pause\":0.01,\"values\":[3,-1]}}");
  (void)state;
  assert_string_equal("application/json", a.raw.type);
  assert_int_equal(CODING_IDENTITY, a.raw.coding);
  assert_memory_equal("{\"message\":\"hä \\\"1\\\"\",\"pause\":0.01,\"values\":[3,-1]}",
                      a.raw.bytes, a.raw.size);
  asked_clear(&a);
}

/* Every member the interface promises. */
static void test_solve_members(void **state) {
  static const char *const objects[] = {"norms", "diagnostics", "report"};
  static const char *const numbers[] = {"norms/value/l1",
                                        "norms/value/l2",
                                        "norms/value/linf",
                                        "norms/value/l2_relative",
                                        "norms/value/linf_all",
                                        "norms/value/points",
                                        "diagnostics/value/spacing/min",
                                        "diagnostics/value/spacing/median",
                                        "diagnostics/value/spacing/max",
                                        "diagnostics/value/neighbours/min",
                                        "diagnostics/value/neighbours/mean",
                                        "diagnostics/value/neighbours/max",
                                        "diagnostics/value/cell_peclet/mean",
                                        "diagnostics/value/cell_peclet/max",
                                        "diagnostics/value/artificial_velocity/max",
                                        "diagnostics/value/bounds/min",
                                        "diagnostics/value/bounds/max",
                                        "diagnostics/value/matrix/rows",
                                        "diagnostics/value/matrix/nonzeros",
                                        "diagnostics/value/solver/iterations",
                                        "diagnostics/value/solver/residual",
                                        "diagnostics/value/solver/reciprocal_condition",
                                        "report/value/threads",
                                        "report/value/seconds/decode",
                                        "report/value/seconds/search",
                                        "report/value/seconds/stencil",
                                        "report/value/seconds/assemble",
                                        "report/value/seconds/factor",
                                        "report/value/seconds/solve",
                                        "report/value/seconds/encode",
                                        "report/value/seconds/total",
                                        "report/value/memory_peak_bytes"};
  asked a = well("solve", LINEAR);
  char pointer[128];
  (void)state;
  for (size_t k = 0; k < 3; k++) assert_int_equal(1, doc_member(a.root, objects[k])->count);
  for (size_t k = 0; k < sizeof numbers / sizeof *numbers; k++) {
    snprintf(pointer, sizeof pointer, "/%s", numbers[k]);
    assert_true(number_at(a.root, pointer) >= 0);
  }
  numbers_at(a.root, "/solution", 81);
  numbers_at(a.root, "/points", 162);
  numbers_at(a.root, "/diagnostics/value/artificial_velocity/rms", 2);
  numbers_at(a.root, "/diagnostics/value/cell_reynolds", 2);
  numbers_at(a.root, "/diagnostics/value/effective_diffusivity/mean", 3);
  numbers_at(a.root, "/diagnostics/value/effective_diffusivity/rms_deviation", 3);
  assert_int_equal(DOC_TEXT, at_pointer(a.root, "/diagnostics/value/solver/method")->kind);
  assert_int_equal(DOC_TEXT, at_pointer(a.root, "/report/value/version")->kind);
  assert_null(doc_member(a.root, "history"));
  assert_true(number_at(a.root, "/norms/value/points") == 49);
  assert_true(number_at(a.root, "/diagnostics/value/matrix/rows") == 49);
  assert_true(number_at(a.root, "/norms/value/linf_all") < 1e-13);
  asked_clear(&a);
}

/* Cell Peclet number |u| h / mu, and what velocity of zero and no diffusivity make of it. */
static void test_peclet(void **state) {
  static const char *const body =
      "{\"inputs\":{\"cloud\":{\"lattice\":{\"lower\":[0],\"upper\":[1],\"cells\":[10]}},"
      "\"velocity\":[3],"
      "\"diffusivity\":0.5,\"boundary\":[{\"on\":\"boundary\",\"type\":\"dirichlet\",\"value\":0}]}"
      ","
      "\"outputs\":{\"diagnostics\":{}}}";
  asked a = well("solve", body);
  (void)state;
  assert_true(fabs(number_at(a.root, "/diagnostics/value/cell_peclet/max") - 0.6) < 1e-14);
  assert_int_equal(1, a.root->count);
  asked_clear(&a);
}

static void test_raw(void **state) {
  char body[1024];
  (void)state;
  snprintf(body, sizeof body, "%.*s, \"outputs\": {\"solution\": {}}, \"response\": \"raw\"}",
           (int)strlen(LINEAR) - 1, LINEAR);
  asked a = well("solve", body);
  assert_int_equal(DOC_NUMBERS, a.root->kind);
  assert_int_equal(81, a.root->count);
  asked_clear(&a);
  snprintf(body, sizeof body, "%.*s, \"outputs\": {\"norms\": {}}, \"response\": \"raw\"}",
           (int)strlen(LINEAR) - 1, LINEAR);
  a = well("solve", body);
  assert_true(number_at(a.root, "/points") == 49);
  asked_clear(&a);
  snprintf(body, sizeof body,
           "%.*s, \"outputs\": {\"norms\": {}, \"points\": {}}, \"response\": \"raw\"}",
           (int)strlen(LINEAR) - 1, LINEAR);
  a = well("solve", body);
  assert_int_equal(2, a.root->count);
  assert_true(number_at(a.root, "/norms/value/points") == 49);
  asked_clear(&a);
}

/* JSON and CBOR, plain and compressed, both ways: the same numbers, bit for bit. */
static void test_forms(void **state) {
  const limits most = asking_limits();
  asked plain = well("solve", LINEAR);
  const double *solution = numbers_at(plain.root, "/solution", 81);
  size_t size;
  void *cbor = cbor_of(LINEAR, &size);
  (void)state;
  for (int k = 0; k < MEDIA_PROBLEM * MEDIA_PROBLEM * CODING_COUNT * CODING_COUNT; k++) {
    const media in = k % 2, out = k / 2 % 2;
    const coding in_coding = k / 4 % CODING_COUNT, out_coding = k / 4 / CODING_COUNT;
    const void *body = in == MEDIA_CBOR ? cbor : (const void *)LINEAR;
    void *packed;
    size_t packed_size;
    assert_int_equal(INFLATE_OK,
                     deflate_bytes(in_coding, body, in == MEDIA_CBOR ? size : strlen(LINEAR),
                                   &packed, &packed_size));
    const ask question = {.process = "solve",
                          .body = packed,
                          .size = packed_size,
                          .content = in,
                          .content_coding = in_coding,
                          .accept = media_wish(out),
                          .accept_coding = out_coding,
                          .limits = &most};
    asked a = ask_all(&question);
    assert_int_equal(200, a.raw.status);
    assert_string_equal(media_type(out), a.raw.type);
    assert_int_equal(out_coding, a.raw.coding);
    assert_memory_equal(solution, numbers_at(a.root, "/solution", 81), 81 * sizeof *solution);
    asked_clear(&a);
    free(packed);
  }
  free(cbor);
  asked_clear(&plain);
}

/* Damaged and overlong bodies. */
static void test_bad_bodies(void **state) {
  limits most = asking_limits();
  void *packed;
  size_t size;
  (void)state;
  assert_int_equal(INFLATE_OK, deflate_bytes(CODING_GZIP, LINEAR, strlen(LINEAR), &packed, &size));
  ask question = {.process = "solve",
                  .body = packed,
                  .size = size - 9,
                  .content_coding = CODING_GZIP,
                  .limits = &most};
  asked a = ask_all(&question);
  assert_int_equal(400, a.raw.status);
  asked_clear(&a);
  most.decoded_bytes = 100;
  question.size = size;
  a = ask_all(&question);
  assert_int_equal(413, a.raw.status);
  asked_clear(&a);
  free(packed);
  most = asking_limits();
  most.depth = 3;
  question = (ask){.process = "solve", .body = LINEAR, .size = strlen(LINEAR), .limits = &most};
  a = ask_all(&question);
  assert_int_equal(413, a.raw.status);
  asked_clear(&a);
  most = asking_limits();
  most.points = 80;
  a = ask_all(&question);
  assert_int_equal(400, a.raw.status);
  assert_non_null(strstr(at_pointer(a.root, "/errors/0/detail")->text, "81 points, at most 80"));
  asked_clear(&a);
  most = asking_limits();
  most.neighbours = 10;
  a = ask_all(&question);
  assert_int_equal(422, a.raw.status);
  asked_clear(&a);
  most = asking_limits();
  most.expression_bytes = 10;
  a = ask_all(&question);
  assert_int_equal(400, a.raw.status);
  asked_clear(&a);
  most = asking_limits();
  most.expression_work = 80; /* of 81 points, with an operation each */
  a = ask_all(&question);
  assert_int_equal(400, a.raw.status);
  assert_non_null(strstr(at_pointer(a.root, "/errors/0/detail")->text, "more than 80 together"));
  asked_clear(&a);
}

/* What the state of a job says of a long problem: whole words of it, and a mark. */
static void test_shortened(void **state) {
  (void)state;
  asked a = ask_json("solve",
                     "{\"inputs\":{\"cloud\":{\"lattice\":{\"lower\":[0,0],\"upper\":[1,1],"
                     "\"cells\":[60,60]}},\"diffusivity\":0,\"boundary\":[{\"on\":\"boundary\","
                     "\"type\":\"dirichlet\",\"value\":0}]}}");
  const char *whole = at_pointer(a.root, "/detail")->text, *part = a.raw.detail;
  const size_t length = strlen(part);
  assert_int_equal(422, a.raw.status);
  assert_true(strlen(whole) >= sizeof a.raw.detail);
  assert_true(length > 4 && length < sizeof a.raw.detail);
  assert_string_equal(" ...", part + length - 4);
  assert_memory_equal(whole, part, length - 4);
  assert_int_equal(' ', whole[length - 4]);
  asked_clear(&a);
}

/* Shuffling the points of a cloud, with its groups, normals and fields, shuffles the answer. */
enum { SIDE = 9, POINTS = SIDE * SIDE };

static void append(char *text, size_t room, const char *format, ...) {
  size_t used = strlen(text);
  va_list list;
  va_start(list, format);
  vsnprintf(text + used, room - used, format, list);
  va_end(list);
}

/* The points x [POINTS][2] posted in the order shuffle[k] = number in x. */
static char *posted_body(const double *x, const int *shuffle) {
  enum { ROOM = 1 << 15 };
  char *body = calloc(1, ROOM);
  int place[POINTS];
  for (int k = 0; k < POINTS; k++) place[shuffle[k]] = k;
  append(body, ROOM, "{\"inputs\":{\"cloud\":{\"points\":[");
  for (int k = 0; k < POINTS; k++) {
    const double *p = x + 2 * shuffle[k];
    append(body, ROOM, "%s[%.17g,%.17g]", k ? "," : "", p[0], p[1]);
  }
  append(body, ROOM, "],\"groups\":{\"left\":[");
  for (int j = 0; j < SIDE; j++) append(body, ROOM, "%s%d", j ? "," : "", place[j * SIDE]);
  append(body, ROOM, "],\"right\":[");
  for (int j = 0; j < SIDE; j++) {
    append(body, ROOM, "%s%d", j ? "," : "", place[j * SIDE + SIDE - 1]);
  }
  append(body, ROOM, "]},\"normals\":{\"right\":[2,0]}},\"diffusivity\":[");
  for (int k = 0; k < POINTS; k++)
    append(body, ROOM, "%s%.17g", k ? "," : "", 1 + x[2 * shuffle[k]]);
  append(body, ROOM, "],\"velocity\":[");
  for (int k = 0; k < POINTS; k++) {
    append(body, ROOM, "%s[%.17g,%d]", k ? "," : "", x[2 * shuffle[k] + 1], 1);
  }
  append(body, ROOM,
         "],\"source\":\"x*y\",\"boundary\":[{\"on\":\"left\",\"type\":\"dirichlet\",\"value\":[");
  for (int j = 0; j < SIDE; j++) append(body, ROOM, "%s%d", j ? "," : "", j);
  append(body, ROOM,
         "]},{\"on\":\"right\",\"type\":\"robin\",\"value\":\"y\",\"coefficient\":0.5}]}}");
  return body;
}

static void test_renumbering(void **state) {
  asked lattice = well("solve", LINEAR);
  const double *x = numbers_at(lattice.root, "/points", 2 * POINTS);
  int same[POINTS], shuffle[POINTS];
  unsigned seed = 12345;
  (void)state;
  for (int k = 0; k < POINTS; k++) same[k] = shuffle[k] = k;
  for (int k = POINTS - 1; k > 0; k--) {
    seed = seed * 1664525u + 1013904223u;
    int other = (int)((seed >> 8) % (unsigned)(k + 1)), kept = shuffle[k];
    shuffle[k] = shuffle[other];
    shuffle[other] = kept;
  }
  char *first = posted_body(x, same), *second = posted_body(x, shuffle);
  asked a = well("solve", first), b = well("solve", second);
  const double *plain = numbers_at(a.root, "/solution", POINTS);
  const double *shuffled = numbers_at(b.root, "/solution", POINTS);
  const double *posted = numbers_at(b.root, "/points", 2 * POINTS);
  for (int k = 0; k < POINTS; k++) {
    assert_true(fabs(plain[shuffle[k]] - shuffled[k]) < 1e-11);
    assert_true(posted[2 * k] == x[2 * shuffle[k]]);
  }
  for (int j = 0; j < SIDE; j++) assert_true(plain[j * SIDE] == j);
  asked_clear(&a);
  asked_clear(&b);
  asked_clear(&lattice);
  free(first);
  free(second);
}

/* In one dimension phi = 1 + 2 x fits each of these. */
static void test_conditions(void **state) {
  static const char *const rights[] = {
      "{\"on\":\"right\",\"type\":\"dirichlet\",\"value\":3}",
      "{\"on\":\"right\",\"type\":\"neumann\",\"value\":2}",
      "{\"on\":[10],\"type\":\"neumann\",\"value\":-2,\"normal\":[-5]}",
      "{\"on\":\"right\",\"type\":\"robin\",\"value\":\"2 + 4*3\",\"coefficient\":4}",
      "{\"on\":\"boundary\",\"type\":\"dirichlet\",\"value\":[1,3]}",
      "{\"on\":[0,10],\"type\":\"dirichlet\",\"value\":[1,9,9,9,9,9,9,9,9,9,3]}",
      "{\"on\":\"right\",\"type\":\"dirichlet\",\"value\":7},"
      "{\"on\":\"right\",\"type\":\"robin\",\"value\":[14],\"coefficient\":[4]}"};
  char body[1024];
  (void)state;
  for (size_t k = 0; k < sizeof rights / sizeof *rights; k++) {
    snprintf(body, sizeof body,
             "{\"inputs\":{\"cloud\":{\"lattice\":{\"lower\":[0],\"upper\":[1],\"cells\":[10],"
             "\"jitter\":"
             "0.4}},\"diffusivity\":2,\"boundary\":[{\"on\":\"left\",\"type\":\"dirichlet\","
             "\"value\":1},"
             "%s],\"exact\":\"1+2*x\"}}",
             rights[k]);
    asked a = well("solve", body);
    assert_true(number_at(a.root, "/norms/value/linf_all") < 1e-12);
    asked_clear(&a);
  }
}

/* phi = (x + t) t + y: linear in x and y at any time, quadratic in t, so Crank-Nicolson is exact;
 * with a time-dependent source, boundary, and, in the second, velocity. */
static void test_time(void **state) {
  static const char *const velocities[] = {"[0, 0]", "[\"t\", \"-t\"]"};
  static const char *const sources[] = {"x + 2*t", "x + 2*t + t*t - t"};
  char body[1024];
  (void)state;
  for (int k = 0; k < 2; k++) {
    snprintf(
        body, sizeof body,
        "{\"inputs\":{\"cloud\":{\"lattice\":{\"lower\":[0,0],\"upper\":[1,1],\"cells\":[5,5],"
        "\"jitter\":0.2}},\"diffusivity\":1,\"velocity\":%s,\"source\":\"%s\",\"initial\":\"y\","
        "\"boundary\":[{\"on\":\"boundary\",\"type\":\"dirichlet\",\"value\":\"(x+t)*t+y\"}],"
        "\"exact\":\"(x+t)*t+y\",\"time\":{\"end\":1,\"step\":0.1,\"save\":[0,0.25,0.5]}}}",
        velocities[k], sources[k]);
    asked a = well("solve", body);
    const double *times = numbers_at(a.root, "/history/value/t", 3);
    assert_true(times[0] == 0 && times[1] == 0.25 && times[2] == 0.5);
    const double *error = numbers_at(a.root, "/history/value/linf", 3);
    assert_true(number_at(a.root, "/norms/value/linf_all") < (k ? 5e-3 : 1e-12));
    assert_true(error[2] < (k ? 5e-3 : 1e-12));
    const doc *saved = at_pointer(a.root, "/history/value/solution");
    assert_true(saved->rank == 2 && saved->shape[0] == 3 && saved->shape[1] == 36);
    assert_true(number_at(a.root, "/diagnostics/value/steps") >= 10);
    asked_clear(&a);
  }
}

/* The explicit scheme by diffusion number: a sine decays, its step is the stable one. */
static void test_explicit(void **state) {
  asked a =
      well("solve",
           "{\"inputs\":{\"cloud\":{\"lattice\":{\"lower\":[0],\"upper\":[1],\"cells\":[64]}},"
           "\"diffusivity\":1,\"initial\":\"sin(pi*x)\",\"exact\":\"exp(-pi^2*t)*sin(pi*x)\","
           "\"operator\":{\"scheme\":\"ps\"},"
           "\"boundary\":[{\"on\":\"boundary\",\"type\":\"dirichlet\",\"value\":0}],"
           "\"time\":{\"method\":\"forward-euler\",\"end\":0.1,\"diffusion_number\":0.5}}}");
  (void)state;
  assert_true(number_at(a.root, "/norms/value/linf_all") < 2e-3);
  double step = number_at(a.root, "/diagnostics/value/step");
  double stable = number_at(a.root, "/diagnostics/value/stable_step");
  assert_true(fabs(step / stable - 0.5) < 1e-2);
  assert_null(at_pointer(a.root, "/diagnostics/value/solver"));
  numbers_at(a.root, "/history/value/t", 0);
  asked_clear(&a);
}

/* Least squares of degree 2 know quadratics; interior is what the lattice says. */
static void test_apply(void **state) {
  asked a =
      well("apply",
           "{\"inputs\":{\"cloud\":{\"lattice\":{\"lower\":[0,0],\"upper\":[1,1],\"cells\":[6,6],"
           "\"jitter\":0.3}},\"field\":\"x^2+x*y\",\"exact_gradient\":[\"2*x+y\",\"x\"],"
           "\"exact_laplacian\":2}}");
  (void)state;
  assert_true(number_at(a.root, "/norms/value/gradient/linf_all") < 1e-11);
  assert_true(number_at(a.root, "/norms/value/laplacian/linf_all") < 1e-10);
  assert_true(number_at(a.root, "/norms/value/laplacian/points") == 25);
  numbers_at(a.root, "/value", 49);
  const doc *gradient = at_pointer(a.root, "/gradient");
  assert_true(gradient->rank == 2 && gradient->shape[0] == 49 && gradient->shape[1] == 2);
  numbers_at(a.root, "/laplacian", 49);
  assert_null(at_pointer(a.root, "/diagnostics/value/matrix"));
  asked_clear(&a);
}

/* The end points of a line have to look further for the two neighbours that a Laplacian needs; what
 * is not made is not told of. */
static void test_rows_of_apply(void **state) {
  static const char line[] =
      "{\"inputs\":{\"cloud\":{\"points\":[0,1,2,3,4],\"spacing\":1},"
      "\"operator\":{\"scheme\":\"ips\"},\"field\":\"x\"},"
      "\"outputs\":{\"diagnostics\":{}%s}}";
  char body[512];
  (void)state;
  snprintf(body, sizeof body, line, ",\"laplacian\":{}");
  asked a = well("apply", body);
  assert_true(number_at(a.root, "/diagnostics/value/widened") == 2);
  assert_true(number_at(a.root, "/diagnostics/value/fallback") == 0);
  asked_clear(&a);
  snprintf(body, sizeof body, line, ",\"value\":{}");
  a = well("apply", body);
  assert_null(at_pointer(a.root, "/diagnostics/value/widened"));
  asked_clear(&a);
}

/* Points of no group are interior; if there are none, all points count. */
static void test_interior(void **state) {
  static const char *const groups[] = {"{}", "{\"a\":[0,4]}", "{\"a\":[0,1,2],\"b\":[2,3,4]}"};
  static const double interior[] = {5, 3, 5};
  char body[512];
  (void)state;
  for (int k = 0; k < 3; k++) {
    snprintf(body, sizeof body,
             "{\"inputs\":{\"cloud\":{\"points\":[[0],[1],[2],[3],[4]],\"groups\":%s},"
             "\"field\":[0,1,2,3,4],\"exact_gradient\":[1]}}",
             groups[k]);
    asked a = well("apply", body);
    assert_true(number_at(a.root, "/norms/value/gradient/points") == interior[k]);
    assert_true(number_at(a.root, "/norms/value/gradient/linf_all") < 1e-12);
    asked_clear(&a);
  }
}

static void test_diagnose(void **state) {
  asked a =
      well("diagnose",
           "{\"inputs\":{\"cloud\":{\"lattice\":{\"lower\":[0,0,0],\"upper\":[1,1,1],\"cells\":"
           "[4,4,4]}},\"operator\":{\"scheme\":\"ps\",\"radius\":1.1}}}");
  const double *neighbours = numbers_at(a.root, "/neighbours", 125);
  (void)state;
  assert_true(neighbours[0] == 3 && neighbours[62] == 6);
  numbers_at(a.root, "/number_density", 125);
  numbers_at(a.root, "/artificial_velocity", 375);
  numbers_at(a.root, "/effective_diffusivity", 750);
  const double *mean = numbers_at(a.root, "/summary/value/effective_diffusivity/mean", 6);
  for (int k = 0; k < 6; k++) assert_true(fabs(mean[k] - (k < 3)) < 1e-12);
  assert_true(number_at(a.root, "/summary/value/artificial_velocity/max") < 1e-10);
  assert_true(fabs(number_at(a.root, "/summary/value/spacing/median") - 0.25) < 1e-15);
  assert_true(number_at(a.root, "/summary/value/deficient/count") == 8); /* the corners */
  numbers_at(a.root, "/summary/value/deficient/points", 8);
  asked_clear(&a);
}

/* Phases are told in their order, and a caller who wants no more is obeyed. */
typedef struct {
  char phases[256];
  int left;
} listener;

static bool listen(void *context, const char *phase, double fraction) {
  listener *l = context;
  assert_true(fraction >= 0 && fraction <= 1);
  if (!strstr(l->phases, phase)) append(l->phases, sizeof l->phases, "%s ", phase);
  return l->left-- != 0;
}

static void test_report(void **state) {
  const limits most = asking_limits();
  listener l = {.left = -1};
  ask question = {.process = "solve",
                  .body = LINEAR,
                  .size = strlen(LINEAR),
                  .limits = &most,
                  .calls = {.report = listen, .context = &l}};
  asked a = ask_all(&question);
  (void)state;
  assert_int_equal(200, a.raw.status);
  asked_clear(&a);
  const char *order[] = {"search", "stencil", "assemble", "factor", "solve", "encode"};
  const char *last = l.phases;
  for (int k = 0; k < 6; k++) {
    const char *at = strstr(l.phases, order[k]);
    assert_true(at >= last);
    last = at;
  }
  for (int k = 0; k < 4; k++) {
    l = (listener){.left = k};
    a = ask_all(&question);
    assert_int_equal(503, a.raw.status);
    asked_clear(&a);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_echo),        cmocka_unit_test(test_solve_members),
      cmocka_unit_test(test_peclet),      cmocka_unit_test(test_raw),
      cmocka_unit_test(test_forms),       cmocka_unit_test(test_bad_bodies),
      cmocka_unit_test(test_renumbering), cmocka_unit_test(test_conditions),
      cmocka_unit_test(test_time),        cmocka_unit_test(test_explicit),
      cmocka_unit_test(test_apply),       cmocka_unit_test(test_rows_of_apply),
      cmocka_unit_test(test_interior),    cmocka_unit_test(test_diagnose),
      cmocka_unit_test(test_report),      cmocka_unit_test(test_shortened),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
