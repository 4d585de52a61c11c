/* Any bytes on a connection of the whole daemon, front and worker in one process (one_process.c):
 * it answers or closes, within a time, and serves the next one. JOB in the bytes stands for the id
 * of the newest job, so that what comes can ask for what came before. */
#include <errno.h>
#include <ftw.h>
#include <poll.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "front.h"
#include "fuzz.h"

enum { LONGEST = 4096, ID = 36, QUIET = 3 /* ms */, PATIENCE = 3000 /* ms */ };

static char folder[64], newest[ID + 1] = "00000000-0000-0000-0000-000000000000";
static struct sockaddr_un address = {.sun_family = AF_UNIX};

/* ---- The daemon ---- */

static const struct {
  const char *name, *value;
} settings[] = {{"workers", "1"},          {"points", "200"},
                {"steps", "20"},           {"neighbours", "60"},
                {"nodes", "2000"},         {"body-bytes", "3KiB"},
                {"spool-bytes", "1KiB"},   {"aside-bytes", "500"},
                {"decoded-bytes", "1MiB"}, {"expression-bytes", "200"},
                {"header-bytes", "2KiB"},  {"job-queue", "20"},
                {"result-seconds", "1"},   {"wait-seconds", "1"},
                {"data-seconds", "2"},     {"data-bytes", "100KiB"},
                {"log-level", "error"}};

static void *serve(void *set) {
  exit(front_main(set) == 0 ? 0 : 2);
}

static int remove_one(const char *path, const struct stat *s, int kind, struct FTW *place) {
  (void)s, (void)kind, (void)place;
  return remove(path);
}

static void clean_up(void) {
  nftw(folder, remove_one, 8, FTW_DEPTH | FTW_PHYS);
}

static int open_connection(void) {
  const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd >= 0 && connect(fd, (const struct sockaddr *)&address, sizeof address) == 0) return fd;
  if (fd >= 0) close(fd);
  return -1;
}

/* Starts it, in memory where there is a folder for that. */
static void start(void) {
  static parameters set;
  static pthread_t thread;
  fault why;
  const char *where = access("/dev/shm", W_OK) == 0 ? "/dev/shm" : "/tmp";
  snprintf(folder, sizeof folder, "%s/fuzz-http-XXXXXX", where);
  if (mkdtemp(folder) == NULL) abort();
  atexit(clean_up);
  param_defaults(&set);
  snprintf(address.sun_path, sizeof address.sun_path, "%s/socket", folder);
  snprintf(set.listen, sizeof set.listen, "unix:%s", address.sun_path);
  snprintf(set.data_dir, sizeof set.data_dir, "%s/data", folder);
  for (size_t k = 0; k < sizeof settings / sizeof *settings; k++) {
    if (!param_set(&set, settings[k].name, settings[k].value, &why)) abort();
  }
  if (pthread_create(&thread, NULL, serve, &set) != 0) abort();
  for (int fd = -1, k = 0; fd < 0; k++) {
    usleep(10000);
    fd = open_connection();
    if (fd >= 0) close(fd);
    if (k == 1000) abort();
  }
}

/* ---- A connection ---- */

/* The bytes with each JOB exchanged for an id; their number. */
static size_t name_job(const uint8_t *data, size_t size, uint8_t *out) {
  size_t used = 0;
  for (size_t k = 0; k < size;) {
    if (size - k >= 3 && memcmp(data + k, "JOB", 3) == 0) {
      memcpy(out + used, newest, ID);
      used += ID;
      k += 3;
    } else {
      out[used++] = data[k++];
    }
  }
  return used;
}

static void note_job(const char *text, size_t size) {
  static const char place[] = "\r\nLocation: ";
  const char *at = memmem(text, size, place, sizeof place - 1);
  const char *id = at == NULL ? NULL : memmem(at, (size_t)(text + size - at), "/jobs/", 6);
  if (id != NULL && id + 6 + ID <= text + size) memcpy(newest, id + 6, ID);
}

/* Reads until nothing comes for so long. False at the end. */
static int read_for(int fd, int milliseconds) {
  char room[8192];
  struct pollfd wait = {.fd = fd, .events = POLLIN};
  while (poll(&wait, 1, milliseconds) > 0) {
    const ssize_t got = recv(fd, room, sizeof room, 0);
    if (got <= 0) return 0;
    if (memcmp(room, "HTTP/1.", got < 7 ? (size_t)got : 7) == 0) note_job(room, (size_t)got);
  }
  return 1;
}

/* Waits until it has answered somebody else, however busy the machine is. */
static void see_it_serve(void) {
  static const char ask[] = "GET /healthz HTTP/1.0\r\n\r\n";
  const int fd = open_connection();
  if (fd < 0 || send(fd, ask, sizeof ask - 1, MSG_NOSIGNAL) < 0) abort();
  if (read_for(fd, 60 * PATIENCE)) abort();
  close(fd);
}

/* What a client sends at once, then it closes its side: the daemon must close the other one. */
static void talk(const uint8_t *bytes, size_t size) {
  const int fd = open_connection();
  if (fd < 0) abort();
  if (send(fd, bytes, size, MSG_NOSIGNAL | MSG_DONTWAIT) < 0 && errno != EPIPE) abort();
  if (read_for(fd, QUIET)) {
    shutdown(fd, SHUT_WR);
    for (int patience = 10; read_for(fd, PATIENCE); patience--) {
      if (patience == 0) {
        fprintf(stderr, "the connection is still open, others are served\n");
        abort();
      }
      see_it_serve();
    }
  }
  close(fd);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static uint8_t room[LONGEST * (ID / 3 + 1)];
  if (*folder == '\0') start();
  if (size == 0 || size > LONGEST) return 0;
  talk(room, name_job(data, size, room));
  return 0;
}
