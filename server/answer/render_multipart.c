/* render_multipart.c - several outputs as multipart/related (RFC 2387): a part per output in its
 * own media type, with its name as Content-ID; of a reference only the Content-Location. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "render_back.h"

enum { BOUNDARY = 64 };

static bool render_parts(task *t, const result *r, rendered part[]) {
  for (int k = 0; k < r->count; k++) {
    const result_output *o = &r->output[k];
    if (!o->by_reference && !render_in(t, r, o, render_own_form(o), &part[k])) return false;
  }
  return true;
}

static bool occurs(const rendered part[], int count, const char *text) {
  for (int k = 0; k < count; k++) {
    const grow_bytes *b = &part[k].bytes;
    if (b->size > 0 && memmem(b->data, b->size, text, strlen(text))) return true;
  }
  return false;
}

/* A boundary that stands in no part; the first try will do but by malice. */
static void choose_boundary(const rendered part[], int count, char boundary[BOUNDARY]) {
  unsigned k = 0;
  do snprintf(boundary, BOUNDARY, "part-of-a-result-%08x", 0x5ca77e6du * ++k);
  while (occurs(part, count, boundary));
}

static bool put_part(task *t, const result_output *o, const rendered *part, const char *boundary,
                     rendered *out) {
  const char *type = o->by_reference ? media_type(render_own_form(o)) : part->type;
  bool done =
      put_text(t, out, "--%s\r\nContent-Type: %s\r\nContent-ID: <%s>\r\n", boundary, type, o->name);
  if (done && o->by_reference) {
    return put_text(t, out, "Content-Location: %s\r\n\r\n\r\n", o->href);
  }
  return done && put_text(t, out, "Content-Length: %zu\r\n\r\n", part->bytes.size) &&
         put(t, out, part->bytes.data, part->bytes.size) && put_text(t, out, "\r\n");
}

bool render_multipart(task *t, const result *r, const result_output *one, rendered *out) {
  rendered part[PROCESS_OUTPUTS_MAX] = {0};
  char boundary[BOUNDARY];
  (void)one;
  bool done = render_parts(t, r, part);
  if (done) choose_boundary(part, r->count, boundary);
  for (int k = 0; done && k < r->count; k++) {
    done = put_part(t, &r->output[k], &part[k], boundary, out);
  }
  if (done) done = put_text(t, out, "--%s--\r\n", boundary);
  if (done && r->count > 0) {
    const char *first = media_type(render_own_form(&r->output[0]));
    snprintf(out->type, sizeof out->type, "multipart/related; boundary=%s; type=\"%s\"", boundary,
             first);
  }
  for (int k = 0; k < r->count; k++) free(part[k].bytes.data);
  return done;
}
