#include "keep.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/sendfile.h>
#include <unistd.h>

enum { PIECE = 4 << 20 };

/* Has the disk begin with a piece and waits for the one before. So never more than two are on their
 * way: who syncs another file meanwhile, as SQLite in the loop, may have to wait for all of them
 * (ext4 with data=ordered). Errors stay for fsync to tell. */
static void push_out(int fd, off_t begin, ssize_t size) {
  enum {
    FINISH = SYNC_FILE_RANGE_WAIT_BEFORE | SYNC_FILE_RANGE_WRITE | SYNC_FILE_RANGE_WAIT_AFTER
  };
  (void)sync_file_range(fd, begin, size, SYNC_FILE_RANGE_WRITE);
  if (begin >= PIECE) (void)sync_file_range(fd, begin - PIECE, PIECE, FINISH);
}

static bool copy(int to, int from, size_t size) {
  off_t at = 0;
  while ((size_t)at < size) {
    const off_t begin = at;
    const size_t left = size - (size_t)at;
    const ssize_t sent = sendfile(to, from, &at, left < PIECE ? left : PIECE);
    if (sent < 0 && errno == EINTR) continue;
    if (sent == 0) errno = EIO; /* it is shorter than it should be */
    if (sent <= 0) return false;
    if (size > PIECE) push_out(to, begin, sent);
  }
  return true;
}

bool keep_file(int at, const char *name, int from, size_t size) {
  char draft[300];
  snprintf(draft, sizeof draft, "%s.draft", name);
  const int to = openat(at, draft, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (to < 0) return false;
  bool good = copy(to, from, size) && fsync(to) == 0;
  int reason = errno;
  close(to);
  if (good) {
    good = renameat(at, draft, at, name) == 0 && fsync(at) == 0;
    reason = errno;
  }
  if (!good) {
    unlinkat(at, draft, 0);
    unlinkat(at, name, 0);
  }
  errno = reason;
  return good;
}

int keep_taken(int at, const char *name, int *from, size_t size) {
  const int error = keep_file(at, name, *from, size) ? 0 : errno;
  if (*from >= 0) close(*from);
  *from = -1;
  return error;
}

bool keep_link(int at, const char *name, const char *other) {
  unlinkat(at, other, 0);
  return linkat(at, name, at, other, 0) == 0 && fsync(at) == 0;
}

int keep_open(int at, const char *name) {
  return openat(at, name, O_RDONLY | O_CLOEXEC);
}

void keep_sweep(int at, bool (*wanted)(void *context, const char *name), void *context) {
  const int own = openat(at, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  DIR *directory = own >= 0 ? fdopendir(own) : NULL;
  if (directory == NULL) {
    if (own >= 0) close(own);
    return;
  }
  for (struct dirent *entry; (entry = readdir(directory)) != NULL;) {
    if (entry->d_type == DT_DIR || wanted(context, entry->d_name)) continue;
    unlinkat(at, entry->d_name, 0);
  }
  closedir(directory);
}
