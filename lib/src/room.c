/* room.c - scratch memory of rows: made once per thread, grown only by a larger neighbourhood. */
#include "alloc.h"
#include "row.h"
#include "stencil_inside.h"

/* Arrays of doubles per neighbour: r, r2, w, f, scratch, laplacian, gradient, fit. */
static int64_t arrays(const sct_room *room) {
  return 5 + 2 * room->dim + room->columns;
}

static void lay_out(sct_room *room) {
  double *next = room->block;
  double **const single[] = {&room->r2, &room->w, &room->f, &room->scratch, &room->laplacian};
  for (int a = 0; a < room->dim; a++, next += room->capacity) room->r[a] = next;
  for (size_t k = 0; k < sizeof single / sizeof single[0]; k++, next += room->capacity) {
    *single[k] = next;
  }
  room->gradient = next;
  room->fit = next + room->dim * room->capacity;
}

sct_status sct_room_reserve(sct_room *room, int64_t n, sct_error *err) {
  if (n <= room->capacity) return SCT_OK;
  const int64_t capacity = n + n / 2;
  double *block = NULL;
  sct_status status = sct_realloc(&room->index, capacity, sizeof *room->index, err);
  if (status == SCT_OK) status = sct_alloc(&block, arrays(room) * capacity, sizeof *block, err);
  if (status != SCT_OK) return status;
  sct_release(&room->block);
  room->block = block;
  room->capacity = capacity;
  lay_out(room);
  return SCT_OK;
}

sct_status sct_room_new(const sct_stencil *stencil, sct_room **out, sct_error *err) {
  sct_room *room = NULL;
  *out = NULL;
  sct_status status = sct_alloc_zero(&room, 1, sizeof *room, err);
  if (status != SCT_OK) return status;
  room->dim = stencil->cloud.dim;
  room->columns = row_unknowns(room->dim, stencil->op.degree);
  status = sct_room_reserve(room, stencil->longest + 1, err);
  if (status != SCT_OK) sct_room_free(&room);
  *out = room;
  return status;
}

void sct_room_free(sct_room **room) {
  if (*room == NULL) return;
  sct_release(&(*room)->block);
  sct_release(&(*room)->index);
  sct_release(room);
}
