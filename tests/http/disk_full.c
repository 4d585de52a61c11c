/* disk_full.c - preloaded into a daemon: while the file $SCATTERD_DISK_FULL exists, nothing can be
 * written below the data directory: ENOSPC, as on a full disk. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/sendfile.h>
#include <unistd.h>

static int is_full(int fd) {
  char link[64], path[512];
  const char *flag = getenv("SCATTERD_DISK_FULL"), *data = getenv("SCATTERD_DISK_DATA");
  if (flag == NULL || data == NULL || access(flag, F_OK) != 0) return 0;
  snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
  const ssize_t length = readlink(link, path, sizeof path - 1);
  return length > 0 && strncmp(path, data, strlen(data)) == 0;
}

#define NEXT(type, name) ((type)dlsym(RTLD_NEXT, name))

ssize_t write(int fd, const void *bytes, size_t size) {
  if (is_full(fd)) return errno = ENOSPC, -1;
  return NEXT(ssize_t(*)(int, const void *, size_t), "write")(fd, bytes, size);
}

ssize_t pwrite64(int fd, const void *bytes, size_t size, off64_t at) {
  if (is_full(fd)) return errno = ENOSPC, -1;
  return NEXT(ssize_t(*)(int, const void *, size_t, off64_t), "pwrite64")(fd, bytes, size, at);
}

ssize_t pwrite(int fd, const void *bytes, size_t size, off_t at) {
  return pwrite64(fd, bytes, size, at);
}

ssize_t sendfile(int to, int from, off_t *at, size_t size) {
  if (is_full(to)) return errno = ENOSPC, -1;
  return NEXT(ssize_t(*)(int, int, off_t *, size_t), "sendfile")(to, from, at, size);
}
