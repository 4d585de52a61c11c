#include "grow.h"

#include <stdint.h>
#include <stdlib.h>

void *grow(void *items, size_t *capacity, size_t needed, size_t size) {
  if (items != NULL && needed <= *capacity) return items;
  size_t wanted = *capacity < 16 ? 16 : *capacity;
  while (wanted < needed && wanted <= SIZE_MAX / 2) wanted *= 2;
  if (wanted < needed || wanted > PTRDIFF_MAX / size) return NULL;
  void *larger = realloc(items, wanted * size);
  if (larger != NULL) *capacity = wanted;
  return larger;
}

char *grow_room(grow_bytes *b, size_t n) {
  if (n > SIZE_MAX - b->size) return NULL;
  char *data = grow(b->data, &b->capacity, b->size + n, 1);
  if (data == NULL) return NULL;
  b->data = data;
  return data + b->size;
}
