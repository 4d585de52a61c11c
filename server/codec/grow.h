/* grow.h - room for one more in an array that doubles. */
#ifndef SCATTERD_GROW_H
#define SCATTERD_GROW_H

#include <stddef.h>

/* Returns `items` with room for at least `needed` items of `size` bytes, *capacity updated; NULL
 * when out of memory, then `items` and *capacity are as before. Appending costs O(1) on average. */
void *grow(void *items, size_t *capacity, size_t needed, size_t size);

/* Bytes that grow. Start with all zero; free `data`. */
typedef struct {
  char *data;
  size_t size, capacity;
} grow_bytes;

/* Where the next `n` bytes may be written (the caller then adds to size), NULL out of memory. */
char *grow_room(grow_bytes *b, size_t n);

#endif
