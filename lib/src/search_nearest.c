/* Distances to nearest neighbours. The points of a bundle bound each other's distances, so that one
 * look around the bundle, that far, settles them all.
 */
#include <float.h>
#include <math.h>

#include "alloc.h"
#include "parallel.h"
#include "search_feed.h"

enum { BUNDLE = 32 };

/* One thread's tools. */
typedef struct {
  sct_feed feed; /* first: `full` gets its address */
  /* Who asks alone, and its answer so far: */
  sct_box box;
  int32_t self;
  double best;
} gauge;

typedef struct {
  const sct_search *search;
  gauge *gauges; /* [threads] */
  double *distance;
} measuring;

/* A radius with which the strict test does not miss a point at this distance. */
static double radius_for(double square) {
  return sqrt(square) * (1 + 4 * DBL_EPSILON);
}

static bool look(sct_feed *feed) {
  gauge *g = (gauge *)feed;
  g->best = fmin(g->best, sct_scan_closest(&feed->scan, g->box.lower, g->self));
  feed->scan.n = 0;
  return true;
}

/* Square of the distance from a place to the nearest other one, which is at most `bound`. Wider
 * and wider balls until one is known to hold it. */
static double measure_alone(gauge *g, int64_t place, double bound) {
  const sct_search *search = g->feed.search;
  double across = 0;
  for (int k = 0; k < search->dim; k++) across += search->box.upper[k] - search->box.lower[k];
  g->box = sct_box_of(search, place);
  g->self = search->order[place];
  g->best = bound;
  g->feed.full = look;
  for (double r = bound < INFINITY ? radius_for(bound) : search->step;; r *= 2) {
    sct_feed_around(&g->feed, &g->box, r);
    look(&g->feed);
    if (g->best <= r * r || r > 2 * across) break;
  }
  g->feed.full = sct_feed_give_up;
  return g->best;
}

static void measure_bundle(const measuring *m, gauge *g, int64_t first, int64_t last) {
  const sct_search *search = m->search;
  const int n = (int)(last - first);
  const int32_t *point = search->order + first;
  sct_box at[BUNDLE], box = sct_box_of(search, first);
  double square[BUNDLE], largest = 0;
  sct_feed_run(&g->feed, first, last);
  for (int k = 0; k < n; k++) {
    at[k] = sct_box_of(search, first + k);
    sct_box_add(&box, search, first + k);
    square[k] = sct_scan_closest(&g->feed.scan, at[k].lower, point[k]);
    largest = fmax(largest, square[k]);
  }
  bool together = n > 1 && sct_feed_around(&g->feed, &box, radius_for(largest));
  for (int k = 0; k < n; k++) {
    square[k] = together ? fmin(square[k], sct_scan_closest(&g->feed.scan, at[k].lower, point[k]))
                         : measure_alone(g, first + k, square[k]);
    m->distance[point[k]] = sqrt(square[k]) / search->scale;
  }
}

static bool measure_slice(void *context, int64_t first, int64_t last, int t) {
  const measuring *m = context;
  for (int64_t p = first, end; p < last; p = end) {
    end = m->search->kind->bundle_end(m->search, p);
    end = end < last ? end : last;
    end = end < p + BUNDLE ? end : p + BUNDLE;
    measure_bundle(m, &m->gauges[t], p, end);
  }
  return true;
}

/* Smallest number above `after` of a point where point i is; -1: none. */
static int64_t company(const sct_search *search, int64_t i, int64_t after) {
  int64_t place = 0, found = -1;
  while (search->order[place] != i) place++;
  for (int64_t p = 0; p < search->n; p++) {
    int64_t j = search->order[p];
    if (j <= after || (found >= 0 && j > found)) continue;
    double square = 0;
    for (int k = 0; k < search->dim; k++) {
      double d = search->x[k][p] - search->x[k][place];
      square += d * d;
    }
    if (square == 0) found = j;
  }
  return found;
}

static bool is_listed(const sct_error *err, int64_t i) {
  for (int64_t k = 0; k < err->count && k < SCT_ERROR_POINTS; k++) {
    if (err->points[k] == i) return true;
  }
  return false;
}

/* Tells the points with distance 0, together with those at the same place, from the lowest on. */
static sct_status coincident(const sct_search *search, const double *distance, int64_t i,
                             sct_error *err) {
  sct_error all;
  sct_fail(&all, SCT_E_COINCIDENT, i, "is at the same place as another");
  int64_t count = 0;
  for (int64_t k = i; k < search->n; k++) {
    if (distance[k] != 0) continue;
    count++;
    if (all.count >= SCT_ERROR_POINTS || (k > i && is_listed(&all, k))) continue;
    if (k > i) sct_error_add_point(&all, k);
    for (int64_t j = k; all.count < SCT_ERROR_POINTS && (j = company(search, k, j)) >= 0;) {
      sct_error_add_point(&all, j);
    }
  }
  all.count = count;
  if (err != NULL) *err = all;
  return SCT_E_COINCIDENT;
}

sct_status sct_search_nearest(const sct_search *search, const sct_work *work, double *distance,
                              sct_error *err) {
  const int threads = sct_work_threads(work);
  measuring m = {search, NULL, distance};
  bool complete;
  sct_status status = sct_alloc_zero(&m.gauges, threads, sizeof *m.gauges, err);
  if (status != SCT_OK) return status;
  for (int t = 0; t < threads; t++) sct_feed_init(&m.gauges[t].feed, search);
  status = sct_in_pieces(search->n, work, "nearest neighbours", measure_slice, &m, &complete, err);
  sct_release(&m.gauges);
  for (int64_t i = 0; i < search->n && status == SCT_OK; i++) {
    if (distance[i] == 0) status = coincident(search, distance, i, err);
  }
  return status;
}
