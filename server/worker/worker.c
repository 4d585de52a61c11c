#include "worker.h"

#include <malloc.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "ipc.h"
#include "sandbox.h"

/* Progress within a phase goes to the front at most this often; the reports in between are free. */
static const double report_seconds = 0.1;

typedef struct {
  double last; /* time of the last report sent */
  char phase[sizeof((ipc_news *)NULL)->phase];
} reporter;

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* A request is stopped by killing the worker, so the answer is always: go on. */
static bool report(void *context, const char *phase, double fraction) {
  reporter *r = context;
  const double time = now();
  ipc_news news = {.kind = IPC_PROGRESS, .time = time, .fraction = fraction};
  snprintf(news.phase, sizeof news.phase, "%s", phase);
  const bool is_new = strcmp(news.phase, r->phase) != 0;
  if (!is_new && time - r->last < report_seconds) return true;
  r->last = time;
  memcpy(r->phase, news.phase, sizeof r->phase);
  return ipc_send(IPC_SOCKET, &news, sizeof news, -1);
}

/* A descriptor that holds the bytes, -1 on failure. */
static int descriptor_of(const void *bytes, size_t size) {
  const int fd = memfd_create("reply", MFD_CLOEXEC);
  if (fd < 0) return -1;
  for (size_t done = 0; done < size;) {
    const ssize_t written = write(fd, (const char *)bytes + done, size - done);
    if (written <= 0) {
      close(fd);
      return -1;
    }
    done += (size_t)written;
  }
  return fd;
}

static bool send_reply(const reply *r) {
  ipc_news news = {.kind = IPC_REPLY,
                   .time = now(),
                   .coding = r->coding,
                   .points = r->points,
                   .memory_bytes = r->memory_bytes};
  int fd = -1;
  if (r->bytes != NULL) fd = descriptor_of(r->bytes, r->size);
  if (fd >= 0) {
    news.status = r->status;
    news.size = (int64_t)r->size;
    snprintf(news.type, sizeof news.type, "%s", r->type);
  }
  const bool sent = ipc_send(IPC_SOCKET, &news, sizeof news, fd);
  if (fd >= 0) close(fd);
  return sent;
}

static void answer_into(const ipc_ask *question, const void *body, reply *r) {
  reporter context = {.last = now()};
  const ask a = {.work = question->work,
                 .process = question->process,
                 .output = question->output,
                 .results_url = question->results_url,
                 .body = body,
                 .size = (size_t)question->size,
                 .content = question->content,
                 .content_coding = question->content_coding,
                 .accept = question->accept,
                 .accept_coding = question->accept_coding,
                 .limits = &question->limits,
                 .calls = {.context = &context, .report = report}};
  answer(&a, r);
}

/* Answers one request whose body is in `fd`; -1 is an empty body. False if the front is gone. */
static bool serve(const ipc_ask *question, int fd) {
  const size_t size = (size_t)question->size;
  reply r = {0};
  void *body = "";
  if (size > 0) body = mmap(NULL, size, PROT_READ, MAP_PRIVATE, fd, 0);
  if (fd >= 0) close(fd);
  if (body == MAP_FAILED) return send_reply(&r); /* no address space left: status 0 */
  answer_into(question, body, &r);
  if (size > 0) munmap(body, size);
  const bool sent = send_reply(&r);
  free(r.bytes);
  return sent;
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
  if (SANDBOXED && !sandbox_enter(&why)) fprintf(stderr, "scatterd: worker without sandbox: %s\n", why.text);
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
  const char *dot = path != NULL ? strrchr(path, '.') : NULL;
  if (dot == NULL) return otherwise;
  return strcmp(dot, ".cbor") == 0 ? MEDIA_CBOR : MEDIA_JSON;
}

int worker_run(const char *process, const char *path, const char *out, const limits *bounds) {
  int status = 2;
  reply r = {0};
  size_t size;
  void *body = read_file(path, &size);
  if (body == NULL) return status;
  const media content = media_of_path(path, MEDIA_JSON);
  const ask a = {.process = process,
                 .body = body,
                 .size = size,
                 .content = content,
                 .accept = media_wish(media_of_path(out, content)),
                 .limits = bounds};
  answer(&a, &r);
  if (r.bytes == NULL) {
    fputs("scatterd: out of memory\n", stderr);
    status = 1;
  } else if (r.status >= 400) {
    fprintf(stderr, "%.*s\n", (int)r.size, (const char *)r.bytes);
    status = 1;
  } else if (write_file(out, r.bytes, r.size)) {
    status = 0;
  }
  free(r.bytes);
  free(body);
  return status;
}
