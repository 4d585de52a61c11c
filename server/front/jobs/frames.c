#include "frames.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

typedef struct {
  int fd;
  int64_t at; /* where the bytes of the frame begin */
  ipc_frame frame;
  frames *out;
  char (*uri)[JOB_URI];
} reader;

static bool read_at(int fd, int64_t at, void *to, size_t size) {
  for (size_t done = 0; done < size;) {
    const ssize_t got = pread(fd, (char *)to + done, size - done, (off_t)(at + (int64_t)done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    done += (size_t)got;
  }
  return true;
}

static bool take_uri(reader *r) {
  char *uri = r->uri[r->frame.kind];
  if (r->frame.size >= JOB_URI) return false;
  memset(uri, 0, JOB_URI);
  return read_at(r->fd, r->at, uri, (size_t)r->frame.size) && strlen(uri) == (size_t)r->frame.size;
}

/* Where the id of an object under /data stands in an href; NULL if it leads elsewhere. */
static const char *data_id(const char *href) {
  static const char folder[] = "/data/";
  const char *slash = strrchr(href, '/');
  const size_t before = sizeof folder - 2; /* up to that slash */
  if (slash == NULL || slash < href + before || strlen(slash + 1) != DATA_ID - 1) return NULL;
  return strncmp(slash - before, folder, before) == 0 ? slash + 1 : NULL;
}

static bool take_href(reader *r) {
  char text[IPC_URL] = "";
  frames *f = r->out;
  if (r->frame.size >= (int64_t)sizeof text) return false;
  if (!read_at(r->fd, r->at, text, (size_t)r->frame.size)) return false;
  f->external |= strncasecmp(text, "http://", 7) == 0 || strncasecmp(text, "https://", 8) == 0;
  const char *id = data_id(text);
  if (id == NULL) return true;
  if (f->pins == JOB_PINS) return false;
  snprintf(f->pin[f->pins++], DATA_ID, "%s", id);
  return true;
}

static bool take_child(reader *r) {
  frames *f = r->out;
  if ((f->count & (f->count - 1)) == 0) { /* full at each power of two */
    const size_t room = f->count > 0 ? 2 * (size_t)f->count : 1;
    job_part *more = realloc(f->parts, room * sizeof *more);
    if (more == NULL) return false;
    f->parts = more;
  }
  job_part *p = &f->parts[f->count++];
  *p = (job_part){.offset = r->at,
                  .size = r->frame.size,
                  .points = r->frame.points,
                  .estimate = r->frame.memory_bytes};
  memcpy(p->process, r->frame.process, sizeof p->process);
  p->process[sizeof p->process - 1] = '\0';
  return true;
}

static bool (*const takes[])(reader *r) = {
    [IPC_FRAME_SUCCESS] = take_uri, [IPC_FRAME_IN_PROGRESS] = take_uri,
    [IPC_FRAME_FAILED] = take_uri,  [IPC_FRAME_HREF] = take_href,
    [IPC_FRAME_CHILD] = take_child,
};

_Static_assert(IPC_FRAME_SUCCESS == 0 && IPC_FRAME_FAILED == 2, "they number the addresses");

bool frames_read(int fd, size_t size, frames *f, char uri[3][JOB_URI]) {
  reader r = {.fd = fd, .out = f, .uri = uri};
  const int64_t end = (int64_t)size;
  *f = (frames){0};
  while (r.at < end) {
    if (end - r.at < (int64_t)sizeof r.frame) return false;
    if (!read_at(fd, r.at, &r.frame, sizeof r.frame)) return false;
    r.at += (int64_t)sizeof r.frame;
    if ((size_t)r.frame.kind >= sizeof takes / sizeof *takes) return false;
    if (r.frame.size < 0 || r.frame.size > end - r.at) return false;
    if (!takes[r.frame.kind](&r)) return false;
    r.at += r.frame.size;
  }
  return true;
}

void frames_free(frames *f) {
  free(f->parts);
  *f = (frames){0};
}
