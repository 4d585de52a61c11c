#include "spool.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/sendfile.h>
#include <unistd.h>

#include "memory_file.h"

static bool write_all(int fd, const char *bytes, size_t size) {
  while (size > 0) {
    const ssize_t written = write(fd, bytes, size);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    bytes += written;
    size -= (size_t)written;
  }
  return true;
}

/* A file without a name; not every file system knows O_TMPFILE. */
static int open_nameless(const char *directory) {
  const int fd = open(directory, O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (fd >= 0 || (errno != EOPNOTSUPP && errno != EISDIR)) return fd;
  char path[4096];
  snprintf(path, sizeof path, "%s/spool-XXXXXX", directory);
  const int named = mkostemp(path, O_CLOEXEC);
  if (named >= 0) unlink(path);
  return named;
}

static bool move_to_disk(spool *s, const char *directory) {
  const int file = open_nameless(directory);
  if (file < 0) return false;
  off_t from = 0;
  while (from < s->size) {
    if (sendfile(file, s->fd, &from, (size_t)(s->size - from)) <= 0) {
      close(file);
      return false;
    }
  }
  if (s->fd >= 0) close(s->fd);
  s->fd = file;
  s->on_disk = true;
  return true;
}

bool spool_add(spool *s, const void *bytes, size_t size, int64_t memory, const char *directory) {
  if (!s->on_disk && s->size + (int64_t)size > memory) {
    if (!move_to_disk(s, directory)) return false;
  }
  if (s->fd < 0) s->fd = memory_file("body");
  if (s->fd < 0 || !write_all(s->fd, bytes, size)) return false;
  s->size += (int64_t)size;
  return true;
}

int spool_take(spool *s) {
  const int fd = s->fd;
  s->fd = -1;
  return fd;
}

bool spool_end(spool *s) {
  return !s->on_disk || s->fd < 0 || file_reopen(&s->fd);
}

void spool_close(spool *s) {
  if (s->fd >= 0) close(s->fd);
  *s = SPOOL_EMPTY;
}
