/* doc_tree.h - makes documents, value by value in order: for the decoders only. */
#ifndef SCATTERD_DOC_TREE_H
#define SCATTERD_DOC_TREE_H

#include "doc.h"

typedef struct {
  doc *node, *tail; /* an open container and its last child */
} doc_level;

typedef struct {
  doc_arena *arena;
  doc *root;
  const char *key; /* of the next value */
  doc_level *open;
  int depth; /* containers open */
} doc_tree;

/* `depth` containers can be open at a time. All memory comes from the arena. */
bool doc_tree_start(doc_tree *t, doc_arena *arena, int depth);

/* Each call adds the next value, or opens or closes a list or object. False when out of memory.
 * Numbers only take their place: doc_tree_settle fills them in. */
bool doc_tree_open(doc_tree *t, doc_kind kind);
void doc_tree_close(doc_tree *t);
bool doc_tree_key(doc_tree *t, const char *key, size_t length);
bool doc_tree_null(doc_tree *t);
bool doc_tree_bool(doc_tree *t, bool truth);
bool doc_tree_text(doc_tree *t, const char *text, size_t length);
bool doc_tree_number(doc_tree *t);
bool doc_tree_numbers(doc_tree *t, int rank, const int64_t *shape);

/* Hands out `values`, the numbers of the whole document in order, to the nodes. */
void doc_tree_settle(doc_tree *t, const double *values);

/* Copies bytes into the arena and puts a NUL behind. NULL when out of memory. */
char *doc_arena_copy(doc_arena *arena, const char *bytes, size_t length);

/* Fills `error` for a body there is no memory for. */
void doc_no_memory(doc_error *error);

/* Lets the arena free malloc'ed memory. When it cannot note that, frees at once: false. */
bool doc_arena_keep(doc_arena *arena, void *memory);

#endif
