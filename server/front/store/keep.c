#include "keep.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/sendfile.h>
#include <unistd.h>

static bool copy(int to, int from, size_t size) {
  off_t at = 0;
  while ((size_t)at < size) {
    const ssize_t sent = sendfile(to, from, &at, size - (size_t)at);
    if (sent < 0 && errno == EINTR) continue;
    if (sent == 0) errno = EIO; /* it is shorter than it should be */
    if (sent <= 0) return false;
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
