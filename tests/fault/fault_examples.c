/* Memory runs out in whole requests: all valid examples of schemas/ and every operation of
 * UM-Bridge. Of requests with many allocations some fail, from a random one on; with SCATTERD_EVERY
 * each of them does, in each of them. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <cmocka.h>
#include <dirent.h>

#include "exhaust.h"
#include "scarce.h"
#include "seed.h"

static const double budget =
    0.25; /* (s) of processor time for one request, unless all are to fail */
static uint64_t seed;
static int64_t requests, failures;

/* ---- What a worker asks the front for ---- */

static void fetch(void *context, const char *href, ask_fetched *out) {
  static const char points[] = "[[0,0],[1,0],[0,1],[1,1],[0.5,0.5],[0.4,0.2],[0.2,0.7]]";
  (void)context, (void)href;
  *out =
      (ask_fetched){.status = 200, .media = MEDIA_JSON, .bytes = points, .size = sizeof points - 1};
}

static void keep(void *context, const char *type, const void *bytes, size_t size, ask_kept *out) {
  (void)context, (void)type, (void)bytes, (void)size;
  *out = (ask_kept){.status = 200, .href = "/data/1"};
}

static bool checkpoint(void *context, const void *bytes, size_t size) {
  (void)context, (void)bytes, (void)size;
  return true;
}

/* ---- One request ---- */

/* Every so-manyth allocation, so that it takes about as long as it may. */
static int64_t stride_of(const ask *question) {
  reply r;
  const clock_t began = clock();
  scarce_after(INT64_MAX, false);
  answer(question, &r);
  (void)scarce_end();
  free(r.bytes);
  if (getenv("SCATTERD_EVERY") != NULL) return 1;
  const double seconds = (double)(clock() - began) / CLOCKS_PER_SEC;
  return 1 + (int64_t)((double)scarce_count() * seconds / budget);
}

static void exhaust(ipc_work work, const char *process, const char *body, size_t size) {
  limits most = asking_limits();
  const ask question = {.work = work,
                        .process = process,
                        .body = body,
                        .size = size,
                        .content = MEDIA_JSON,
                        .accept = media_wish(MEDIA_JSON),
                        .limits = &most,
                        .calls = {.fetch = fetch, .keep = keep, .checkpoint = checkpoint}};
  const int64_t stride = stride_of(&question);
  for (int lasting = 0; lasting <= 1; lasting++) {
    const int64_t first = (int64_t)(seed_next(&seed) % (uint64_t)stride);
    const int64_t failed = exhaust_each(&question, lasting, first, stride);
    failures += failed;
  }
  requests++;
}

/* ---- The examples ---- */

static size_t read_example(const char *name, char *room, size_t size) {
  char path[512];
  snprintf(path, sizeof path, "%s/%s", SCATTERD_EXAMPLES, name);
  FILE *file = fopen(path, "rb");
  assert_non_null(file);
  const size_t length = fread(room, 1, size, file);
  assert_true(length < size);
  fclose(file);
  return length;
}

static void examples(void **state) {
  static char body[1 << 16];
  char process[32];
  struct dirent *entry;
  (void)state;
  DIR *all = opendir(SCATTERD_EXAMPLES);
  assert_non_null(all);
  while ((entry = readdir(all)) != NULL) {
    if (strstr(entry->d_name, ".ok-") == NULL) continue;
    const size_t size = read_example(entry->d_name, body, sizeof body);
    snprintf(process, sizeof process, "%.*s", (int)strcspn(entry->d_name, "."), entry->d_name);
    exhaust(IPC_CHECK, process, body, size);
    if (strcmp(process, "batch") == 0) continue; /* its parts are the ones that run */
    exhaust(IPC_RUN_STORED, process, body, size);
    exhaust(IPC_RUN, process, body, size);
  }
  closedir(all);
  printf("%lld requests, %lld allocations failed\n", (long long)requests, (long long)failures);
  assert_true(requests > 100);
}

/* ---- UM-Bridge ---- */

#define CONFIG                                                                                     \
  "{\"cloud\":{\"lattice\":{\"lower\":[0],\"upper\":[1],\"cells\":[8]}},\"diffusivity\":\"a\","    \
  "\"velocity\":[\"b\"],\"source\":\"a*x\",\"boundary\":[{\"on\":\"boundary\",\"type\":"           \
  "\"dirichlet\",\"value\":\"b\"}],\"parameters\":{\"a\":1,\"b\":0.5},\"inputs\":[[\"a\",\"b\"]]," \
  "\"outputs\":{\"mean\":\"mean\"}%s}"

static const char still[] = "", moving[] = ",\"initial\":0,\"time\":{\"end\":0.01,\"step\":0.005}";

static const char *const operations[][2] = {
    {"ModelInfo", ""},
    {"InputSizes", ""},
    {"OutputSizes", ""},
    {"Evaluate", ",\"input\":[[1,0.5]]"},
    {"Gradient", ",\"input\":[[1,0.5]],\"outWrt\":0,\"inWrt\":0,\"sens\":[1]"},
    {"ApplyJacobian", ",\"input\":[[1,0.5]],\"outWrt\":0,\"inWrt\":0,\"vec\":[1,2]"}};

static void models(void **state) {
  static char body[2048], process[64];
  (void)state;
  for (size_t k = 0; k < 2 * (sizeof operations / sizeof *operations); k++) {
    const char *const *o = operations[k / 2];
    const int length = snprintf(body, sizeof body, "{\"name\":\"solve\",\"config\":" CONFIG "%s}",
                                k % 2 == 0 ? still : moving, o[1]);
    snprintf(process, sizeof process, "um-bridge/%s", o[0]);
    exhaust(IPC_RUN, process, body, (size_t)length);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(models), cmocka_unit_test(examples)};
  seed = seed_new("fault.examples");
  return cmocka_run_group_tests(tests, NULL, NULL);
}
