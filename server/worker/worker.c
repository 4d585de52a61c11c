#include "worker.h"

#include <errno.h>
#include <malloc.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "ipc.h"
#include "memory_file.h"
#include "sandbox.h"
#include "teller.h"

/* Progress within a phase goes to the front at most this often; the reports in between are free. */
static const double report_seconds = 0.1;

/* One request being answered. */
typedef struct {
  const ipc_ask *question;
  teller teller;
} session;

/* A request is stopped by killing the worker, so the answer is always: go on. */
static bool report(void *context, const char *phase, double fraction) {
  session *s = context;
  ipc_news news;
  if (!teller_takes(&s->teller, phase, fraction, &news)) return true;
  return ipc_send(IPC_SOCKET, &news, sizeof news, -1);
}

static void hear_residual(void *context, double value) {
  session *s = context;
  s->teller.residual = value;
}

/* A descriptor that holds the bytes, which the front takes only as they are; -1 on failure. */
static int descriptor_of(const void *bytes, size_t size) {
  const int fd = memory_file("reply");
  size_t done = 0;
  while (fd >= 0 && done < size) {
    const ssize_t written = write(fd, (const char *)bytes + done, size - done);
    if (written <= 0) break;
    done += (size_t)written;
  }
  if (fd < 0 || (done == size && memory_file_seal(fd))) return fd;
  close(fd);
  return -1;
}

/* Something of the machine's has run out, not of the request's: this worker ends, and a job is
 * tried again by another one. */
static bool lack(const char *what) {
  fprintf(stderr, "scatterd: worker %d ends, %s: %s\n", (int)getpid(), what, strerror(errno));
  return false;
}

/* False if the front is gone, or this worker is to end. */
static bool send_reply(const reply *r) {
  ipc_news news = {.kind = IPC_REPLY,
                   .time = teller_now(),
                   .coding = r->coding,
                   .points = r->points,
                   .memory_bytes = r->memory_bytes};
  int fd = -1;
  if (r->bytes != NULL) {
    fd = descriptor_of(r->bytes, r->size);
    if (fd < 0) return lack("no file for the reply");
    news.status = r->status;
    news.size = (int64_t)r->size;
    snprintf(news.type, sizeof news.type, "%s", r->type);
    memcpy(news.detail, r->detail, sizeof news.detail);
  }
  const bool sent = ipc_send(IPC_SOCKET, &news, sizeof news, fd);
  if (fd >= 0) close(fd);
  return sent;
}

/* ---- What an answer asks for ---- */

/* Asks the front for something and waits for what it gives. */
static bool exchange(const ipc_news *news, int fd, ipc_given *given, int *given_fd) {
  *given_fd = -1;
  return ipc_send(IPC_SOCKET, news, sizeof *news, fd) &&
         ipc_receive(IPC_SOCKET, given, sizeof *given, given_fd) == IPC_MESSAGE;
}

/* Maps `size` bytes of fd, which is closed; NULL on failure. */
static void *map(int fd, int64_t size) {
  void *bytes = "";
  if (fd < 0 && size > 0) return NULL;
  if (size > 0) bytes = mmap(NULL, (size_t)size, PROT_READ, MAP_PRIVATE, fd, 0);
  if (fd >= 0) close(fd);
  return bytes == MAP_FAILED ? NULL : bytes;
}

static void unmap(const void *bytes, size_t size) {
  if (bytes != NULL && size > 0) munmap((void *)bytes, size);
}

static void fetch(void *context, const char *href, ask_fetched *out) {
  ipc_news news = {.kind = IPC_FETCH};
  ipc_given given;
  int fd;
  (void)context;
  snprintf(news.href, sizeof news.href, "%s", href);
  if (!exchange(&news, -1, &given, &fd)) {
    *out = (ask_fetched){.status = 503, .detail = "the service is being stopped"};
    return;
  }
  *out = (ask_fetched){.status = given.status, .media = given.media, .coding = given.coding};
  memcpy(out->output, given.output, sizeof out->output);
  memcpy(out->detail, given.detail, sizeof out->detail);
  if (given.status != 200) return;
  out->bytes = map(fd, given.size);
  out->size = out->bytes != NULL ? (size_t)given.size : 0;
  if (out->bytes != NULL) return;
  out->status = 422;
  snprintf(out->detail, sizeof out->detail, "no memory for %lld bytes", (long long)given.size);
}

static void release(void *context, ask_fetched *out) {
  (void)context;
  unmap(out->bytes, out->size);
}

static void keep(void *context, const char *type, const void *bytes, size_t size, ask_kept *out) {
  const session *s = context;
  ipc_news news = {.kind = IPC_KEEP, .size = (int64_t)size};
  ipc_given given = {.status = 422, .detail = "no memory for a value by reference"};
  int given_fd = -1;
  const int fd = descriptor_of(bytes, size);
  snprintf(news.type, sizeof news.type, "%s", type);
  if (fd >= 0 && !exchange(&news, fd, &given, &given_fd)) given.status = 503;
  if (fd >= 0) close(fd);
  if (given_fd >= 0) close(given_fd);
  *out = (ask_kept){.status = given.status};
  snprintf(out->href, sizeof out->href, "%.*s%.128s", IPC_URL - 130, s->question->base, given.href);
  snprintf(out->detail, sizeof out->detail, "%s", given.detail);
}

static bool checkpoint(void *context, const void *bytes, size_t size) {
  const ipc_news news = {.kind = IPC_CHECKPOINT, .size = (int64_t)size};
  const int fd = descriptor_of(bytes, size);
  (void)context;
  if (fd < 0) return true; /* the run goes on without it */
  const bool sent = ipc_send(IPC_SOCKET, &news, sizeof news, fd);
  close(fd);
  return sent;
}

/* ---- One request ---- */

typedef struct {
  void *bytes;
  size_t size;
} mapped;

static void answer_into(const ipc_ask *question, mapped body, mapped state, reply *r) {
  session s = {.question = question, .teller = {.pause = report_seconds, .last = teller_now()}};
  const ask a = {.work = question->work,
                 .process = question->process,
                 .output = question->output,
                 .results_url = question->results_url,
                 .body = body.bytes,
                 .size = body.size,
                 .content = question->content,
                 .content_coding = question->content_coding,
                 .accept = question->accept,
                 .accept_coding = question->accept_coding,
                 .limits = &question->limits,
                 .checkpoint = state.size > 0 ? state.bytes : NULL,
                 .checkpoint_size = state.size,
                 .calls = {&s, report, hear_residual, fetch, release, keep, checkpoint}};
  answer(&a, r);
}

/* The checkpoint that an ask announced. False if the front is gone. */
static bool take_checkpoint(const ipc_ask *question, mapped *state) {
  ipc_given given;
  int fd;
  *state = (mapped){0};
  if (question->checkpoint <= 0) return true;
  if (ipc_receive(IPC_SOCKET, &given, sizeof given, &fd) != IPC_MESSAGE) return false;
  state->bytes = map(fd, given.size);
  if (state->bytes != NULL) state->size = (size_t)given.size;
  return true; /* without it the run starts afresh */
}

/* Answers one request whose body is in `fd`; -1 is an empty body. False if the front is gone. */
static bool serve(const ipc_ask *question, int fd) {
  reply r = {0};
  mapped state, body = {map(fd, question->size), (size_t)question->size};
  bool served = take_checkpoint(question, &state);
  if (served && body.bytes != NULL) answer_into(question, body, state, &r);
  served = served && send_reply(&r); /* no address space left for the body: status 0 */
  unmap(body.bytes, body.size);
  unmap(state.bytes, state.size);
  free(r.bytes);
  return served;
}

/* Memory of one request serves the next: without this each array of 128 KiB or more is mapped and
 * its pages are cleared anew, a third of the time of a small solve. */
static void keep_memory(void) {
#ifdef __GLIBC__
  enum { ARRAYS = 32 << 20, TRIM = 256 << 20 };
  (void)mallopt(M_MMAP_THRESHOLD, ARRAYS);
  (void)mallopt(M_TRIM_THRESHOLD, TRIM);
#endif
}

int worker_main(void) {
  const ipc_news ready = {.kind = IPC_READY};
  fault why;
  keep_memory();
  answer_prepare();
  if (SANDBOXED && !sandbox_enter(&why))
    fprintf(stderr, "scatterd: worker without sandbox: %s\n", why.text);
  if (!ipc_send(IPC_SOCKET, &ready, sizeof ready, -1)) {
    fputs("scatterd: a worker is started by the daemon only\n", stderr);
    return 2;
  }
  ipc_ask question;
  int fd;
  while (ipc_receive(IPC_SOCKET, &question, sizeof question, &fd) == IPC_MESSAGE) {
    if (!serve(&question, fd)) break;
  }
  return 0;
}

/* ---- scatterd run ---- */

/* All of a file, malloc'ed; NULL with errno on failure. */
static void *read_all(FILE *file, size_t *size) {
  char *bytes = NULL;
  size_t room = 0;
  *size = 0;
  do {
    if (room - *size < 65536) {
      room = 2 * room + 65536;
      char *larger = realloc(bytes, room);
      if (larger == NULL) break;
      bytes = larger;
    }
    *size += fread(bytes + *size, 1, room - *size, file);
  } while (!feof(file) && !ferror(file));
  if (feof(file)) return bytes;
  free(bytes);
  return NULL;
}

static void *read_file(const char *path, size_t *size) {
  const bool is_stdin = strcmp(path, "-") == 0;
  FILE *file = is_stdin ? stdin : fopen(path, "rb");
  void *bytes = file != NULL ? read_all(file, size) : NULL;
  if (bytes == NULL) perror(path);
  if (file != NULL && !is_stdin) fclose(file);
  return bytes;
}

static bool write_file(const char *path, const void *bytes, size_t size) {
  const bool is_stdout = path == NULL || strcmp(path, "-") == 0;
  FILE *file = is_stdout ? stdout : fopen(path, "wb");
  bool good = file != NULL && fwrite(bytes, 1, size, file) == size && fflush(file) == 0;
  if (!good) perror(is_stdout ? "standard output" : path);
  if (file != NULL && !is_stdout) good = fclose(file) == 0 && good;
  return good;
}

static media media_of_path(const char *path, media otherwise) {
  static const struct {
    const char *ending;
    media media;
  } endings[] = {{".json", MEDIA_JSON},
                 {".cbor", MEDIA_CBOR},
                 {".npy", MEDIA_NPY},
                 {".csv", MEDIA_CSV},
                 {".vtp", MEDIA_VTP}};
  const char *dot = path != NULL ? strrchr(path, '.') : NULL;
  for (size_t k = 0; dot != NULL && k < sizeof endings / sizeof *endings; k++) {
    if (strcmp(dot, endings[k].ending) == 0) return endings[k].media;
  }
  return otherwise;
}

/* Values by reference are files beside the request. */
static void fetch_file(void *context, const char *href, ask_fetched *out) {
  const char *request = context, *slash = strrchr(request, '/');
  char path[4096];
  size_t size;
  const int folder = slash != NULL ? (int)(slash - request) + 1 : 0;
  if (strstr(href, "://") != NULL || strlen(href) + (size_t)folder >= sizeof path) {
    snprintf(out->detail, sizeof out->detail, "leads to another host, needs the name of a file");
    return;
  }
  snprintf(path, sizeof path, "%.*s%s", *href != '/' ? folder : 0, request, href);
  out->bytes = read_file(path, &size);
  if (out->bytes == NULL) {
    snprintf(out->detail, sizeof out->detail, "leads to a file that cannot be read: %s",
             strerror(errno));
    return;
  }
  out->status = 200;
  out->size = size;
  out->media = media_of_path(path, MEDIA_JSON);
}

static void release_file(void *context, ask_fetched *out) {
  (void)context;
  free((void *)out->bytes);
}

/* Writes a reply where it belongs; returns the exit status. */
static int finish(const char *out, const reply *r) {
  if (r->bytes == NULL) {
    fputs("scatterd: out of memory\n", stderr);
    return 1;
  }
  if (r->status < 400) return write_file(out, r->bytes, r->size) ? 0 : 2;
  fprintf(stderr, "%.*s\n", (int)r->size, (const char *)r->bytes);
  return 1;
}

int worker_run(const char *process, const char *path, const char *out, const limits *bounds) {
  reply r = {0};
  size_t size;
  void *body = read_file(path, &size);
  if (body == NULL) return 2;
  const media content = media_of_path(path, MEDIA_JSON);
  const ask a = {.process = process,
                 .body = body,
                 .size = size,
                 .content = content,
                 .accept = media_wish(media_of_path(out, content)),
                 .limits = bounds,
                 .calls = {.context = (void *)path, .fetch = fetch_file, .release = release_file}};
  answer(&a, &r);
  const int status = finish(out, &r);
  free(r.bytes);
  free(body);
  return status;
}
