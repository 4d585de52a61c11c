#include "memory_file.h"

#include <fcntl.h>
#include <stdio.h>
#include <sys/mman.h>
#include <unistd.h>

static const int content = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE;

int memory_file(const char *name) {
  return memfd_create(name, MFD_CLOEXEC | MFD_ALLOW_SEALING);
}

bool memory_file_seal(int fd) {
  return fcntl(fd, F_ADD_SEALS, content | F_SEAL_SEAL) == 0;
}

bool memory_file_is_sealed(int fd) {
  const int seals = fcntl(fd, F_GET_SEALS);
  return seals >= 0 && (seals & content) == content;
}

bool file_reopen(int *fd) {
  char path[32];
  snprintf(path, sizeof path, "/proc/self/fd/%d", *fd);
  const int reader = open(path, O_RDONLY | O_CLOEXEC);
  if (reader < 0) return false;
  close(*fd);
  *fd = reader;
  return true;
}
