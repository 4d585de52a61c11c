#include "doc.h"

#include <inttypes.h>
#include <math.h>
#include <stdalign.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "doc_tree.h"

/* Arena: a list of blocks, each twice as large as the one before up to a limit, and a list of
 * foreign memory to free. */
typedef struct block block;
struct block {
  block *next;
  size_t size, used;
  alignas(16) char bytes[];
};

typedef struct kept kept;
struct kept {
  kept *next;
  void *memory;
};

struct doc_arena {
  block *blocks;
  kept *keeps;
};

enum { BLOCK_FIRST = 4096, BLOCK_LAST = 1 << 20 };

doc_arena *doc_arena_new(void) {
  return calloc(1, sizeof(doc_arena));
}

static block *block_new(doc_arena *arena, size_t least) {
  size_t size = BLOCK_FIRST;
  if (arena->blocks != NULL && arena->blocks->size >= BLOCK_FIRST / 2) {
    size = arena->blocks->size >= BLOCK_LAST ? BLOCK_LAST : 2 * arena->blocks->size;
  }
  if (size < least) size = least;
  block *b = malloc(sizeof *b + size);
  if (b == NULL) return NULL;
  *b = (block){.next = arena->blocks, .size = size};
  arena->blocks = b;
  return b;
}

void *doc_arena_take(doc_arena *arena, size_t bytes) {
  if (bytes > PTRDIFF_MAX - 2 * sizeof(block)) return NULL;
  bytes = (bytes + 15) & ~(size_t)15;
  block *b = arena->blocks;
  if (b == NULL || bytes > b->size - b->used) b = block_new(arena, bytes);
  if (b == NULL) return NULL;
  void *memory = b->bytes + b->used;
  b->used += bytes;
  return memory;
}

char *doc_arena_copy(doc_arena *arena, const char *bytes, size_t length) {
  char *copy = doc_arena_take(arena, length + 1);
  if (copy == NULL) return NULL;
  if (length > 0) memcpy(copy, bytes, length);
  copy[length] = '\0';
  return copy;
}

bool doc_arena_keep(doc_arena *arena, void *memory) {
  kept *k = doc_arena_take(arena, sizeof *k);
  if (k == NULL) {
    free(memory);
    return false;
  }
  *k = (kept){.next = arena->keeps, .memory = memory};
  arena->keeps = k;
  return true;
}

void doc_arena_free(doc_arena **arena) {
  if (*arena == NULL) return;
  for (kept *k = (*arena)->keeps; k != NULL; k = k->next) free(k->memory);
  for (block *b = (*arena)->blocks, *next; b != NULL; b = next) {
    next = b->next;
    free(b);
  }
  free(*arena);
  *arena = NULL;
}

void doc_arena_adopt(doc_arena *into, doc_arena **from) {
  block **blocks = into->blocks != NULL ? &into->blocks->next : &into->blocks;
  block **last = &(*from)->blocks;
  kept **end = &(*from)->keeps;
  while (*last != NULL) last = &(*last)->next;
  while (*end != NULL) end = &(*end)->next;
  *last = *blocks; /* behind the first, which has room */
  *blocks = (*from)->blocks;
  *end = into->keeps;
  into->keeps = (*from)->keeps;
  free(*from);
  *from = NULL;
}

void doc_no_memory(doc_error *error) {
  error->too_large = true;
  error->pointer[0] = '\0';
  snprintf(error->text, sizeof error->text, "no memory left for the body");
}

const doc *doc_member(const doc *d, const char *key) {
  if (d == NULL || d->kind != DOC_OBJECT) return NULL;
  const doc *child = d->child;
  while (child != NULL && strcmp(child->key, key) != 0) child = child->next;
  return child;
}

const doc *doc_at(const doc *list, int64_t k) {
  if (list == NULL || list->kind != DOC_LIST || k < 0) return NULL;
  const doc *child = list->child;
  while (child != NULL && k-- > 0) child = child->next;
  return child;
}

static const char *describe_number(const doc *d) {
  if (isnan(d->number)) return "NaN";
  return isinf(d->number) ? "an infinite number" : "a number";
}

static const char *describe_numbers(const doc *d, char *room, size_t size) {
  if (d->count == 0) return "an empty array";
  char shape[64] = "";
  for (int k = 0, used = 0; k < d->rank; k++) {
    used += snprintf(shape + used, sizeof shape - (size_t)used, "%s%" PRId64, k ? " x " : "",
                     d->shape[k]);
  }
  snprintf(room, size, "an array of %s number%s", shape, d->count == 1 ? "" : "s");
  return room;
}

static const char *describe_children(const doc *d, const char *what, const char *each, char *room,
                                     size_t size) {
  snprintf(room, size, "%s of %" PRId64 " %s%s", what, d->count, each, d->count == 1 ? "" : "s");
  return room;
}

const char *doc_describe(const doc *d, char *room, size_t size) {
  switch (d->kind) {
    case DOC_NULL:
      return "null";
    case DOC_BOOL:
      return d->truth ? "true" : "false";
    case DOC_NUMBER:
      return describe_number(d);
    case DOC_TEXT:
      return "a string";
    case DOC_LIST:
      return describe_children(d, "a list", "value", room, size);
    case DOC_OBJECT:
      return describe_children(d, "an object", "member", room, size);
    case DOC_NUMBERS:
      return describe_numbers(d, room, size);
  }
  return "nothing";
}
