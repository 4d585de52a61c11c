#include "points.h"

/* The failure so far and the block it comes from. */
typedef struct {
  int64_t block;
  sct_error error;
} failure;

static bool is_deficiency(const sct_error *error) {
  return error->code == SCT_E_DEFICIENT;
}

static bool is_fatal(const sct_error *error) {
  return error->code != SCT_OK && !is_deficiency(error);
}

/* Deficient points are added up, from the lowest block on; anything else outranks them. */
static void note(failure *worst, int64_t block, const sct_error *error) {
  const bool lower = block < worst->block;
  if (is_deficiency(error) && is_deficiency(&worst->error)) {
    sct_error low = lower ? *error : worst->error;
    sct_error_merge(&low, lower ? &worst->error : error);
    worst->error = low;
    if (lower) worst->block = block;
  } else if (worst->error.code == SCT_OK || is_fatal(error) > is_fatal(&worst->error) ||
             (is_fatal(error) && lower)) {
    *worst = (failure){block, *error};
  }
}

/* One block; the deficient points of it are added up in `err`. */
static sct_status run_block(int64_t first, int64_t end, sct_points_work *work_on, void *context,
                            sct_room *room, sct_error *err) {
  err->code = SCT_OK;
  for (int64_t i = first; i < end; i++) {
    sct_error one;
    if (work_on(context, i, room, &one) == SCT_OK) continue;
    if (is_fatal(&one)) *err = one;
    if (is_fatal(&one)) break;
    sct_error_merge(err, &one);
  }
  return err->code;
}

sct_status sct_points_run(const sct_stencil *stencil, int64_t first, int64_t end,
                          const sct_work *work, sct_points_work *work_on, void *context,
                          sct_error *err) {
  const int64_t blocks = (end - first + SCT_POINTS_BLOCK - 1) / SCT_POINTS_BLOCK;
  failure worst = {.block = 0, .error = {.code = SCT_OK}};
#pragma omp parallel num_threads(sct_work_threads(work)) if (blocks > 1)
  {
    sct_room *room = NULL;
    sct_error mine = {.code = SCT_OK};
    if (sct_room_new(stencil, &room, &mine) != SCT_OK) {
#pragma omp critical(sct_points)
      note(&worst, -1, &mine);
    }
#pragma omp for schedule(dynamic)
    for (int64_t block = 0; block < blocks; block++) {
      bool stop;
#pragma omp critical(sct_points)
      stop = is_fatal(&worst.error);
      if (room == NULL || stop) continue;
      const int64_t from = first + block * SCT_POINTS_BLOCK;
      const int64_t to = from + SCT_POINTS_BLOCK < end ? from + SCT_POINTS_BLOCK : end;
      if (run_block(from, to, work_on, context, room, &mine) != SCT_OK) {
#pragma omp critical(sct_points)
        note(&worst, block, &mine);
      }
    }
    sct_room_free(&room);
  }
  if (err != NULL && worst.error.code != SCT_OK) *err = worst.error;
  return worst.error.code;
}
