#include "scatter/search.h"

#include <math.h>
#include <string.h>

#include "alloc.h"
#include "search_feed.h"
#include "search_kind.h"

/* Cells are given up for the tree where a point shares its cell with so many, on average. */
static const double crowding_most = 16;

static const sct_search_kind_of *const kinds[SCT_SEARCH_COUNT] = {
    [SCT_SEARCH_GRID] = &sct_search_grid,
    [SCT_SEARCH_TREE] = &sct_search_tree,
};

/* -- build ------------------------------------------------------------------------------------- */

static void bound(sct_search *search, const sct_cloud *cloud) {
  for (int k = 0; k < cloud->dim; k++) {
    double lower = cloud->x[k], upper = lower;
    for (const double *x = cloud->x + k; x < cloud->x + cloud->n * cloud->dim; x += cloud->dim) {
      lower = *x < lower ? *x : lower;
      upper = *x > upper ? *x : upper;
    }
    search->box.lower[k] = lower;
    search->box.upper[k] = upper;
  }
}

/* Squares of lengths between 2^-400 and 2^400 are far from the ends of double precision. Clouds
 * outside are scaled by a power of two, which changes no digit. */
static void rescale(sct_search *search) {
  enum { COMFORT = 400, LEAST = -1000 /* whose reciprocal is a number */ };
  double half = 0;
  sct_box *box = &search->box;
  for (int k = 0; k < search->dim; k++) {
    half = fmax(half, box->upper[k] / 2 - box->lower[k] / 2); /* the whole may overflow */
  }
  int exponent = 0;
  frexp(half, &exponent);
  if (exponent < LEAST) exponent = LEAST;
  search->scale = abs(exponent) > COMFORT ? ldexp(1, -exponent) : 1;
  for (int k = 0; k < search->dim; k++) {
    box->lower[k] *= search->scale;
    box->upper[k] *= search->scale;
  }
}

static sct_status build_kind(sct_search *search, const sct_cloud *cloud, sct_search_method method,
                             sct_error *err) {
  search->kind = kinds[method == SCT_SEARCH_AUTO ? SCT_SEARCH_GRID : method];
  sct_status status = search->kind->build(search, cloud, err);
  if (status != SCT_OK || method != SCT_SEARCH_AUTO) return status;
  if (search->cells.crowding <= crowding_most) return SCT_OK;
  search->kind->clear(search);
  search->kind = kinds[SCT_SEARCH_TREE];
  return search->kind->build(search, cloud, err);
}

static void gather(sct_search *search, const sct_cloud *cloud) {
  for (int64_t p = 0; p < search->n; p++) {
    const double *x = cloud->x + (int64_t)search->order[p] * search->dim;
    for (int k = 0; k < search->dim; k++) search->x[k][p] = x[k] * search->scale;
  }
}

sct_status sct_search_build(const sct_cloud *cloud, double radius, sct_search_method method,
                            const sct_work *work, sct_search **search, sct_error *err) {
  *search = NULL;
  sct_search *s = NULL;
  sct_status status = sct_cloud_check(cloud, err);
  if (status != SCT_OK) return status;
  if (!(radius >= 0)) {
    return sct_fail(err, SCT_E_ARGUMENT, -1, "search radius is %g, needs to be 0 or more", radius);
  }
  if ((unsigned)method >= SCT_SEARCH_COUNT) {
    return sct_fail(err, SCT_E_ARGUMENT, -1, "search method %d does not exist", (int)method);
  }
  status = sct_work_report(work, "search", 0, err);
  if (status == SCT_OK) status = sct_alloc_zero(&s, 1, sizeof *s, err);
  if (status != SCT_OK) return status;
  s->dim = cloud->dim;
  s->n = cloud->n;
  bound(s, cloud);
  rescale(s);
  status = sct_alloc(&s->order, s->n, sizeof *s->order, err);
  if (status == SCT_OK) status = build_kind(s, cloud, method, err);
  for (int k = 0; k < s->dim && status == SCT_OK; k++) {
    status = sct_alloc(&s->x[k], s->n, sizeof(double), err);
  }
  if (status == SCT_OK) {
    gather(s, cloud);
    *search = s;
  } else {
    sct_search_free(&s);
  }
  return status;
}

void sct_search_free(sct_search **search) {
  if (search == NULL || *search == NULL) return;
  sct_search *s = *search;
  if (s->kind != NULL) s->kind->clear(s);
  for (int k = 0; k < SCT_DIM_MAX; k++) sct_release(&s->x[k]);
  sct_release(&s->order);
  sct_release(search);
}

sct_search_method sct_search_kind(const sct_search *search) {
  return search->kind->method;
}

const char *sct_search_method_name(sct_search_method method) {
  if (method == SCT_SEARCH_AUTO) return "auto";
  return (unsigned)method < SCT_SEARCH_COUNT ? kinds[method]->name : NULL;
}

/* -- around ------------------------------------------------------------------------------------ */

/* Hits on their way to memory of a fixed size. */
typedef struct {
  sct_feed feed;   /* first: `full` gets its address */
  const double *x; /* [dim] scaled */
  double square;
  int32_t *index; /* [capacity] */
  int64_t capacity, n;
} asking;

static bool pour(sct_feed *feed) {
  asking *a = (asking *)feed;
  int32_t hit[SCT_SCAN_MOST + SCT_SCAN_PAD];
  int64_t n = sct_scan_hits(&feed->scan, a->x, a->square, -1, hit);
  int64_t room = a->capacity > a->n ? a->capacity - a->n : 0, kept = n < room ? n : room;
  if (kept > 0) memcpy(a->index + a->n, hit, (size_t)kept * sizeof *hit);
  a->n += n;
  feed->scan.n = 0;
  return true;
}

int64_t sct_search_around(const sct_search *search, const double *x, double radius,
                          int64_t capacity, int32_t *index) {
  if (!(radius > 0)) return 0;
  asking a; /* large: only what is needed is set */
  a.index = index;
  a.capacity = capacity;
  a.n = 0;
  sct_feed_init(&a.feed, search);
  radius *= search->scale;
  a.square = radius * radius;
  a.feed.full = pour;
  sct_box box = {{0}, {0}};
  for (int k = 0; k < search->dim; k++) box.lower[k] = box.upper[k] = x[k] * search->scale;
  a.x = box.lower;
  sct_feed_around(&a.feed, &box, radius);
  pour(&a.feed);
  return a.n;
}
