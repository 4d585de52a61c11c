/* Any bytes as what a worker says of a request it checked: the front takes them or not, never
 * worse, since a worker may have been taken over by what it read. */
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "frames.h"
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static char uri[3][JOB_URI];
  static int fd = -1;
  frames f;
  if (fd < 0) fd = memfd_create("frames", MFD_CLOEXEC);
  if (fd < 0 || ftruncate(fd, 0) != 0 || pwrite(fd, data, size, 0) != (ssize_t)size) abort();
  memset(uri, 0, sizeof uri);
  if (frames_read(fd, size, &f, uri)) {
    for (int k = 0; k < f.count; k++) {
      const job_part *p = &f.parts[k];
      if (p->offset < 0 || p->size < 0 || p->offset + p->size > (int64_t)size) abort();
      if (memchr(p->process, '\0', sizeof p->process) == NULL) abort();
    }
    for (int k = 0; k < f.pins; k++) {
      if (strlen(f.pin[k]) != DATA_ID - 1) abort();
    }
  }
  for (int k = 0; k < 3; k++) {
    if (memchr(uri[k], '\0', JOB_URI) == NULL) abort();
  }
  frames_free(&f);
  return 0;
}
