#include "check.h"

#include <string.h>

#include "by_href.h"
#include "data_url.h"

bool check_put(task *t, const ipc_frame *head, const void *bytes, grow_bytes *frames) {
  char *room = grow_room(frames, sizeof *head + (size_t)head->size);
  if (!room) {
    (void)sct_fail(&t->error, SCT_E_MEMORY, -1, "no memory for the frames of a check");
    return false;
  }
  memcpy(room, head, sizeof *head);
  if (head->size > 0) memcpy(room + sizeof *head, bytes, (size_t)head->size);
  frames->size += sizeof *head + (size_t)head->size;
  return true;
}

static bool put_text(task *t, ipc_frame_kind kind, const char *text, grow_bytes *frames) {
  const ipc_frame head = {.kind = kind, .size = (int64_t)strlen(text)};
  return check_put(t, &head, text, frames);
}

static bool put_subscriber(task *t, const execute *x, grow_bytes *frames) {
  static const ipc_frame_kind kinds[SUBSCRIBER_CALLS] = {IPC_FRAME_SUCCESS, IPC_FRAME_IN_PROGRESS,
                                                         IPC_FRAME_FAILED};
  for (int k = 0; k < SUBSCRIBER_CALLS; k++) {
    if (x->subscriber[k] && !put_text(t, kinds[k], x->subscriber[k], frames)) return false;
  }
  return true;
}

/* What is in the request itself needs no pinning. */
static bool put_hrefs(task *t, grow_bytes *frames) {
  for (const href_entry *e = t->by_href ? t->by_href->first : NULL; e; e = e->next) {
    if (data_url_is(e->href)) continue;
    if (!put_text(t, IPC_FRAME_HREF, e->href, frames)) return false;
  }
  return true;
}

bool check_frames(task *t, const performance *f, grow_bytes *frames) {
  if (!put_subscriber(t, &f->wanted, frames) || !put_hrefs(t, frames)) return false;
  return !f->process->children || f->process->children(t, f->state, frames);
}
