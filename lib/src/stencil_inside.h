/* stencil_inside.h - what a prepared stencil holds; for the files that make and use rows. */
#ifndef SCATTER_STENCIL_INSIDE_H
#define SCATTER_STENCIL_INSIDE_H

#include "row.h"

struct sct_stencil {
  sct_cloud cloud;
  const sct_search *search;
  sct_operator op;
  double spacing;
  double reference_w, reference_w_r2; /* S_w and lambda S_w of a complete lattice neighbourhood */
  int64_t limit;                      /* neighbours of one point */
  int64_t longest;                    /* longest list */
  sct_lists *lists;                   /* neighbours within op.radius * spacing, ascending */
  double *reach;                      /* [n] the widest support looked at; NULL: nobody asks */
};

/* Makes room for n neighbours; what it held is lost if it has to grow. SCT_E_MEMORY. */
SCT_NODISCARD sct_status sct_room_reserve(sct_room *room, int64_t n, sct_error *err);

/* Lays out the neighbours of i within op.radius * spacing in the room: index, r, r2, and with
 * `weigh` w and f; returns how many. */
int64_t sct_stencil_gather(const sct_stencil *stencil, int64_t i, sct_room *room, bool weigh,
                           const int32_t **index);

#endif
