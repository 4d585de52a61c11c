/* Neighbour lists in one pass over the sorted places, which keeps memory access local whatever
 * the numbering of the cloud: each thread appends the rows it finds to memory of its own, and at
 * the end they are put in the order of the points. Counting first and filling second would test
 * all distances twice; taking the points in their own order saves the second copy where that order
 * is a good one, but costs as much by neighbours that share less.
 */
#include <inttypes.h>
#include <string.h>

#include "alloc.h"
#include "parallel.h"
#include "search_feed.h"

enum { FEW = 16 /* neighbours per point that memory is taken for at a time */ };
static const int64_t entries_most = (int64_t)1 << 40;

/* One thread's part of the lists. */
typedef struct {
  sct_feed feed;  /* first: `full` gets its address */
  int32_t *index; /* [n] */
  int64_t n, capacity, copied;
  int64_t step; /* by which the memory grows at least */
  int64_t most; /* n must not go beyond */
  sct_status status;
  sct_error err;
  sct_box box; /* who asks alone */
  int32_t self;
  double square;
} part;

typedef struct {
  const sct_search *search;
  double radius;
  const double *radii;
  int64_t limit;
  part *parts; /* [threads] */
  sct_lists *lists;
} listing;

static double radius_of(const listing *l, int64_t place) {
  double radius = l->radii != NULL ? l->radii[l->search->order[place]] : l->radius;
  return radius * l->search->scale;
}

/* -- finding ----------------------------------------------------------------------------------- */

static bool make_room(part *mine) {
  int64_t needed = mine->n + SCT_SCAN_MOST + SCT_SCAN_PAD;
  if (needed <= mine->capacity) return true;
  int64_t half = mine->capacity / 2, capacity = needed + (half > mine->step ? half : mine->step);
  mine->status = sct_realloc(&mine->index, capacity, sizeof *mine->index, &mine->err);
  if (mine->status == SCT_OK) mine->capacity = capacity;
  return mine->status == SCT_OK;
}

/* Appends what the scan has for the point in mine->box. */
static bool append(part *mine) {
  if (!make_room(mine)) return false;
  mine->n += sct_scan_hits(&mine->feed.scan, mine->box.lower, mine->square, mine->self,
                           mine->index + mine->n);
  return mine->n <= mine->most;
}

static bool append_full(sct_feed *feed) {
  bool more = append((part *)feed);
  feed->scan.n = 0;
  return more;
}

/* More points are around than a scan holds: it is emptied on the way. */
static void ask_alone(part *mine, double radius) {
  mine->feed.full = append_full;
  if (sct_feed_around(&mine->feed, &mine->box, radius)) append(mine);
  mine->feed.full = sct_feed_give_up;
}

/* Is the row that begins at `before` what it may be? Notes its length. */
static bool finish_row(const listing *l, part *mine, double radius, int64_t before) {
  if (mine->status != SCT_OK) return false;
  if (mine->n > mine->most) {
    mine->status = sct_fail(&mine->err, SCT_E_LIMIT, mine->self,
                            "has more than %" PRId64 " neighbours within %g", l->limit,
                            radius / l->search->scale);
  } else if (mine->n > entries_most) {
    mine->status =
        sct_fail(&mine->err, SCT_E_LIMIT, mine->self, "makes more than 2^40 neighbours in all");
  }
  l->lists->start[mine->self + 1] = mine->n - before;
  return mine->status == SCT_OK;
}

/* The rows of places that are close together: one look around all of them serves all. */
static bool list_bundle(const listing *l, part *mine, int64_t first, int64_t last) {
  const sct_search *search = l->search;
  sct_box box = sct_box_of(search, first);
  double radius = 0;
  for (int64_t p = first; p < last; p++) {
    double own = radius_of(l, p);
    radius = own > radius ? own : radius;
    sct_box_add(&box, search, p);
  }
  bool together = sct_feed_around(&mine->feed, &box, radius);
  for (int64_t p = first; p < last; p++) {
    int64_t before = mine->n;
    radius = radius_of(l, p);
    mine->box = sct_box_of(search, p);
    mine->self = search->order[p];
    mine->square = radius * radius;
    mine->most = before + l->limit;
    if (together) {
      append(mine);
    } else {
      ask_alone(mine, radius);
    }
    if (!finish_row(l, mine, radius, before)) return false;
  }
  return true;
}

static bool list_slice(void *context, int64_t first, int64_t last, int t) {
  enum { BUNDLE = 64 };
  const listing *l = context;
  for (int64_t p = first, end; p < last; p = end) {
    end = l->search->kind->bundle_end(l->search, p);
    end = end < last ? end : last;
    end = end < p + BUNDLE ? end : p + BUNDLE;
    if (!list_bundle(l, &l->parts[t], p, end)) return false;
  }
  return true;
}

/* -- packing ----------------------------------------------------------------------------------- */

static bool copy_slice(void *context, int64_t first, int64_t last, int t) {
  const listing *l = context;
  part *mine = &l->parts[t];
  for (int64_t p = first; p < last; p++) {
    int32_t i = l->search->order[p];
    int64_t start = l->lists->start[i], n = l->lists->start[i + 1] - start;
    memcpy(l->lists->index + start, mine->index + mine->copied, (size_t)n * sizeof(int32_t));
    mine->copied += n;
  }
  return true;
}

/* The failure of the first place that has one: it is the same for every number of threads. */
static sct_status first_failure(const listing *l, sct_error *err) {
  const part *p = l->parts;
  while (p->status == SCT_OK) p++;
  if (err != NULL) *err = p->err;
  return p->status;
}

static sct_status list_all(listing *l, const sct_work *work, sct_error *err) {
  sct_lists *lists = l->lists;
  bool complete;
  sct_status status = sct_in_pieces(lists->n, work, "neighbours", list_slice, l, &complete, err);
  if (status != SCT_OK) return status;
  if (!complete) return first_failure(l, err);
  for (int64_t i = 0; i < lists->n; i++) lists->start[i + 1] += lists->start[i];
  status = sct_alloc(&lists->index, lists->start[lists->n], sizeof(int32_t), err);
  if (status != SCT_OK) return status;
  return sct_in_pieces(lists->n, work, "neighbour lists", copy_slice, l, &complete, err);
}

/* -- lists ------------------------------------------------------------------------------------- */

static sct_status check_radii(const sct_search *search, double radius, const double *radii,
                              sct_error *err) {
  if (radii == NULL) {
    if (radius >= 0) return SCT_OK;
    return sct_fail(err, SCT_E_ARGUMENT, -1, "radius is %g, needs to be 0 or more", radius);
  }
  for (int64_t i = 0; i < search->n; i++) {
    if (radii[i] >= 0) continue;
    return sct_fail(err, SCT_E_ARGUMENT, i, "has search radius %g, needs 0 or more", radii[i]);
  }
  return SCT_OK;
}

sct_status sct_search_lists(const sct_search *search, double radius, const double *radii,
                            int64_t limit, const sct_work *work, sct_lists **lists,
                            sct_error *err) {
  *lists = NULL;
  const int threads = sct_work_threads(work);
  listing l = {search, radius, radii, limit < 0 ? 0 : limit, NULL, NULL};
  sct_status status = check_radii(search, radius, radii, err);
  if (status == SCT_OK) status = sct_alloc_zero(&l.parts, threads, sizeof *l.parts, err);
  if (status == SCT_OK) status = sct_alloc_zero(&l.lists, 1, sizeof *l.lists, err);
  if (status != SCT_OK) goto done;
  for (int t = 0; t < threads; t++) {
    sct_feed_init(&l.parts[t].feed, search);
    l.parts[t].step = (l.limit < FEW ? l.limit : FEW) * (search->n / threads);
  }
  l.lists->n = search->n;
  status = sct_alloc_zero(&l.lists->start, search->n + 1, sizeof *l.lists->start, err);
  if (status == SCT_OK) status = list_all(&l, work, err);
done:
  for (int t = 0; l.parts != NULL && t < threads; t++) sct_release(&l.parts[t].index);
  sct_release(&l.parts);
  if (status != SCT_OK) sct_lists_free(&l.lists);
  *lists = l.lists;
  return status;
}

void sct_lists_free(sct_lists **lists) {
  if (lists == NULL || *lists == NULL) return;
  sct_release(&(*lists)->start);
  sct_release(&(*lists)->index);
  sct_release(lists);
}
