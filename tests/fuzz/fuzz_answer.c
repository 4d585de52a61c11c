/* Any bytes as a whole request to the worker: a result or a problem that blames the request, never
 * a failure. The first line says what of it the front would say, by single letters that stand for
 * the rows of the tables below ("ajra" is solve, JSON, run, nothing wished); the body follows. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "answer.h"
#include "fuzz.h"

/* Open MPI, behind PETSc, keeps what it learns of the machine. */
const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void) {
  return "leak:libhwloc\nleak:mca_\nleak:libopen-\nleak:hypre_\n";
}

static const char *const processes[] = {"solve",
                                        "apply",
                                        "diagnose",
                                        "study",
                                        "flow",
                                        "echo",
                                        "batch",
                                        "um-bridge/Evaluate",
                                        "um-bridge/Gradient",
                                        "um-bridge/ApplyJacobian",
                                        "um-bridge/InputSizes",
                                        "data"};
static const media contents[] = {MEDIA_JSON, MEDIA_CBOR, MEDIA_JSON,
                                 MEDIA_CBOR, MEDIA_CSV,  MEDIA_NPY};
static const ipc_work works[] = {IPC_RUN, IPC_RUN, IPC_RUN_STORED, IPC_CHECK};
static const media accepts[] = {MEDIA_COUNT, MEDIA_JSON, MEDIA_CBOR,     MEDIA_NPY,
                                MEDIA_VTP,   MEDIA_CSV,  MEDIA_MULTIPART};

/* The row a letter stands for: 'a' is the first. */
static int row_of(uint8_t letter, size_t rows) {
  return (letter >= 'a' ? letter - 'a' : letter) % (int)rows;
}
#define ROW(table, letter) table[row_of(letter, sizeof(table) / sizeof *(table))]

enum { REPORTS = 3000, HEAD = 5 };

/* Small, so that what is right is soon done. */
static const limits most = {.body_bytes = 1 << 16,
                            .decoded_bytes = 1 << 18,
                            .depth = 32,
                            .nodes = 2000,
                            .points = 300,
                            .neighbours = 60,
                            .expression_bytes = 400,
                            .expression_work = 1000000,
                            .steps = 20,
                            .memory_bytes = INT64_C(1) << 30,
                            .seconds = 5,
                            .threads = 1};

/* Nobody waits for a pause, nor for long. */
static bool report(void *context, const char *phase, double fraction) {
  int *left = context;
  (void)fraction;
  return strcmp(phase, "pause") != 0 && --*left > 0;
}

/* Every reference leads to the same three points, or their text. */
static void fetch(void *context, const char *href, ask_fetched *out) {
  static const char points[] = "[[0,0],[1,0],[0,1]]", table[] = "x,y\n0,0\n1,0\n0,1\n";
  const bool is_table = strstr(href, "csv") != NULL;
  (void)context;
  *out = (ask_fetched){.status = strstr(href, "none") != NULL ? 404 : 200,
                       .bytes = is_table ? table : points,
                       .size = is_table ? sizeof table - 1 : sizeof points - 1,
                       .media = is_table ? MEDIA_CSV : MEDIA_JSON,
                       .detail = "there is nothing"};
}

static void release(void *context, ask_fetched *out) {
  (void)context, (void)out;
}

static void keep(void *context, const char *type, const void *bytes, size_t size, ask_kept *out) {
  (void)context, (void)type, (void)bytes, (void)size;
  *out = (ask_kept){.status = 200, .href = "http://here/data/1"};
}

static bool checkpoint(void *context, const void *bytes, size_t size) {
  (void)context, (void)bytes, (void)size;
  return true;
}

static void judge(const ask *question, const reply *r) {
  const bool is_fine =
      r->status == 200 || r->status == 204 || (r->status >= 400 && r->status < 500);
  const bool is_bridge = strncmp(question->process, "um-bridge/", 10) == 0; /* fails by 500 */
  const bool is_short = r->status == 503 || r->status == 500; /* stopped, or the library's limit */
  if (r->bytes != NULL && (is_fine || (is_bridge && is_short) || r->status == 503)) return;
  fprintf(stderr, "%s: %d %s %.*s\n", question->process, r->status, r->detail, (int)r->size,
          r->bytes == NULL ? "" : (const char *)r->bytes);
  abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  int left = REPORTS;
  reply r;
  if (size < HEAD || data[HEAD - 1] != '\n') return 0;
  const media wished = ROW(accepts, data[3]);
  const ask question = {.work = ROW(works, data[2]),
                        .process = ROW(processes, data[0]),
                        .body = data + HEAD,
                        .size = size - HEAD,
                        .content = ROW(contents, data[1]),
                        .accept = wished == MEDIA_COUNT ? (wishes){0} : media_wish(wished),
                        .limits = &most,
                        .calls = {.context = &left,
                                  .report = report,
                                  .fetch = fetch,
                                  .release = release,
                                  .keep = keep,
                                  .checkpoint = checkpoint}};
  answer(&question, &r);
  judge(&question, &r);
  free(r.bytes);
  return 0;
}
