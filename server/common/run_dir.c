#include "run_dir.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/sendfile.h>
#include <sys/stat.h>
#include <unistd.h>

/* Before a record: its size, by which another version is told from this one. */
typedef struct {
  char magic[8];
  uint64_t size;
} record_head;

static const char magic[8] = "scatterd";

int run_dir_open(const char *path) {
  return open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
}

/* ---- files ---- */

static bool write_all(int fd, const char *bytes, size_t size) {
  while (size > 0) {
    const ssize_t written = write(fd, bytes, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes += written;
    size -= (size_t)written;
  }
  return true;
}

static bool copy_all(int to, int from, size_t size) {
  off_t at = 0;
  while ((size_t)at < size) {
    const ssize_t sent = sendfile(to, from, &at, size - (size_t)at);
    if (sent < 0 && errno == EINTR) continue;
    if (sent == 0) errno = EIO;
    if (sent <= 0) return false;
  }
  return true;
}

/* A file under another name until it is complete. `head` may be NULL. */
static bool put(int dir, const char *name, const record_head *head, const void *bytes, int from,
                size_t size) {
  char draft[80];
  snprintf(draft, sizeof draft, "%.60s.draft.%d", name, (int)getpid());
  const int to = openat(dir, draft, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (to < 0) return false;
  bool good = head == NULL || write_all(to, (const char *)head, sizeof *head);
  good = good && (bytes != NULL ? write_all(to, bytes, size) : copy_all(to, from, size));
  good = good && fsync(to) == 0;
  int reason = errno;
  close(to);
  if (good && renameat(dir, draft, dir, name) == 0) return true;
  if (good) reason = errno;
  unlinkat(dir, draft, 0);
  errno = reason;
  return false;
}

bool run_dir_put(int dir, const char *name, const void *bytes, size_t size) {
  return put(dir, name, NULL, bytes != NULL ? bytes : "", -1, size);
}

bool run_dir_copy(int dir, const char *name, int from, size_t size) {
  return put(dir, name, NULL, NULL, from, size);
}

int run_dir_get(int dir, const char *name, int64_t *size) {
  struct stat facts;
  const int fd = openat(dir, name, O_RDONLY | O_CLOEXEC);
  if (fd < 0) return -1;
  if (fstat(fd, &facts) != 0 || !S_ISREG(facts.st_mode)) {
    close(fd);
    errno = EPROTO;
    return -1;
  }
  *size = (int64_t)facts.st_size;
  return fd;
}

/* ---- records ---- */

static bool put_record(int dir, const char *name, const void *record, size_t size) {
  record_head head = {.size = size};
  memcpy(head.magic, magic, sizeof magic);
  return put(dir, name, &head, record, -1, size);
}

static bool get_record(int dir, const char *name, void *record, size_t size) {
  int64_t there = 0;
  record_head head;
  const int fd = run_dir_get(dir, name, &there);
  if (fd < 0) return false;
  const bool good = there == (int64_t)(sizeof head + size) &&
                    pread(fd, &head, sizeof head, 0) == (ssize_t)sizeof head &&
                    memcmp(head.magic, magic, sizeof magic) == 0 && head.size == size &&
                    pread(fd, record, size, sizeof head) == (ssize_t)size;
  close(fd);
  if (!good) errno = EPROTO;
  return good;
}

bool run_dir_put_ask(int dir, const ipc_ask *ask) {
  return put_record(dir, "ask", ask, sizeof *ask);
}

bool run_dir_get_ask(int dir, ipc_ask *ask) {
  return get_record(dir, "ask", ask, sizeof *ask);
}

bool run_dir_put_reply(int dir, const ipc_news *reply) {
  return put_record(dir, "reply", reply, sizeof *reply);
}

bool run_dir_get_reply(int dir, ipc_news *reply) {
  return get_record(dir, "reply", reply, sizeof *reply);
}

bool run_dir_tell(int dir, const ipc_news *news) {
  const int fd = openat(dir, "news", O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
  if (fd < 0) return false;
  const bool good = write_all(fd, (const char *)news, sizeof *news);
  close(fd);
  return good;
}

bool run_dir_hear(int dir, int64_t *at, ipc_news *news) {
  const int fd = openat(dir, "news", O_RDONLY | O_CLOEXEC);
  if (fd < 0) return false;
  const bool good = pread(fd, news, sizeof *news, (off_t)*at) == (ssize_t)sizeof *news;
  close(fd);
  if (!good) return false;
  *at += (int64_t)sizeof *news;
  news->phase[sizeof news->phase - 1] = '\0';
  return true;
}

void run_dir_remove(int at, const char *name) {
  const int own = openat(at, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  DIR *directory = own >= 0 ? fdopendir(own) : NULL;
  if (directory == NULL && own >= 0) close(own);
  if (directory == NULL) return;
  for (struct dirent *entry; (entry = readdir(directory)) != NULL;) {
    if (strcmp(entry->d_name, ".") == 0 || strcmp(entry->d_name, "..") == 0) continue;
    if (unlinkat(dirfd(directory), entry->d_name, 0) == 0) continue;
    (void)unlinkat(dirfd(directory), entry->d_name, AT_REMOVEDIR); /* an empty one */
  }
  closedir(directory);
  (void)unlinkat(at, name, AT_REMOVEDIR);
}
