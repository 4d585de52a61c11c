/* by_href.h - inputs by reference: {"href": ...} anywhere among the inputs becomes the value that
 * stands there.
 *
 * `data:` URLs are read here, all others are asked of the caller (ask_calls.fetch). A value may be
 * JSON, CBOR, .npy or CSV; one that is asked for twice is fetched once. For an input that is a text
 * CSV is just that, not a table of numbers.
 * Proof: unit.by_href, fault.answer, http.data
 */
#ifndef SCATTERD_BY_HREF_H
#define SCATTERD_BY_HREF_H

#include "answer.h"
#include "read.h"

enum { HREFS_MAX = 32 }; /* different ones of one request */

typedef struct href_entry href_entry;
struct href_entry {
  href_entry *next;
  const char *href;
  bool is_text;     /* for an input that is a text */
  const doc *value; /* NULL: there is none, and why has been said */
};

/* What a request has fetched; belongs to its outermost task. */
typedef struct by_href {
  const ask_calls *calls;
  doc_arena *arena; /* of entries and values */
  href_entry *first;
  int count;
  const item *inputs;       /* while they are resolved */
  const char *const *texts; /* names of those that are texts, NULL at the end */
} by_href;

/* Frees what was fetched. */
void by_href_clear(by_href *b);

/* Puts values in the places of bytes in base64 ({"value", "encoding", "mediaType"}) and
 * of all references within `inputs`, whose nodes are changed. What cannot be had is a complaint
 * that points to its href; true if there was none. texts: the inputs that are texts, NULL: none. */
bool by_href_resolve(task *t, const item *inputs, const char *const *texts);

#endif
