#include "scatter/search.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "alloc.h"
#include "parallel.h"
#include "radix.h"
#include "search_kind.h"

/* Cells are given up for the tree where a point shares its cell with so many, on average. */
static const double crowding_most = 16;

static const sct_search_kind_of *const kinds[SCT_SEARCH_COUNT] = {
    [SCT_SEARCH_GRID] = &sct_search_grid,
    [SCT_SEARCH_TREE] = &sct_search_tree,
};

/* -- build --------------------------------------------------------------------------------------
 */

/* Squares of lengths between 2^-400 and 2^400 are far from the ends of double precision. Clouds
 * outside are scaled by a power of two, which changes no digit. */
static double scale_of(const sct_cloud *cloud) {
  enum { COMFORT = 400 };
  double largest = 0;
  for (int k = 0; k < cloud->dim; k++) {
    double lower = cloud->x[k], upper = lower;
    for (int64_t i = 1; i < cloud->n; i++) {
      double x = cloud->x[i * cloud->dim + k];
      if (x < lower) lower = x;
      if (x > upper) upper = x;
    }
    largest = fmax(largest, upper / 2 - lower / 2);
  }
  int exponent = 0;
  frexp(largest, &exponent);
  return abs(exponent) > COMFORT ? ldexp(1, -exponent) : 1;
}

static sct_status build_kind(sct_search *search, const sct_cloud *cloud, double radius,
                             sct_search_method method, sct_error *err) {
  search->kind = kinds[method == SCT_SEARCH_AUTO ? SCT_SEARCH_GRID : method];
  sct_status status = search->kind->build(search, cloud, radius, err);
  if (status != SCT_OK || method != SCT_SEARCH_AUTO) return status;
  if (search->cells.crowding <= crowding_most) return SCT_OK;
  search->kind->clear(search);
  search->kind = kinds[SCT_SEARCH_TREE];
  return search->kind->build(search, cloud, radius, err);
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
  s->scale = scale_of(cloud);
  status = sct_alloc(&s->order, s->n, sizeof *s->order, err);
  if (status == SCT_OK) status = build_kind(s, cloud, radius * s->scale, method, err);
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

/* -- work in pieces -----------------------------------------------------------------------------
 */

/* Something to do for the places first .. last-1 on thread t. False: it failed, stop. */
typedef bool slice_work(void *context, int64_t first, int64_t last, int t);

/* The places are worked through in pieces, between which the caller is told; a piece is cut into
 * one slice per thread. *failed says whether a slice did. */
static sct_status in_pieces(int64_t n, const sct_work *work, const char *phase, slice_work *slice,
                            void *context, bool *failed, sct_error *err) {
  enum { PIECE = 1 << 17 };
  const int threads = sct_work_threads(work);
  bool ok = true;
  for (int64_t piece = 0; piece < n && ok; piece += PIECE) {
    int64_t length = n - piece < PIECE ? n - piece : PIECE;
    sct_status status = sct_work_report(work, phase, (double)piece / (double)n, err);
    if (status != SCT_OK) return status;
    SCT_PARALLEL_FOR(threads, ok)
    for (int t = 0; t < threads; t++) {
      int64_t first = piece + length * t / threads, last = piece + length * (t + 1) / threads;
      ok = slice(context, first, last, t) && ok;
    }
  }
  *failed = !ok;
  return SCT_OK;
}

static sct_query ask_at(const sct_search *search, int64_t place, double radius) {
  sct_query query = {.radius = radius, .square = radius * radius, .self = place};
  for (int k = 0; k < search->dim; k++) query.x[k] = search->x[k][place];
  return query;
}

/* -- lists --------------------------------------------------------------------------------------
 */

/* One thread's part of the lists. */
typedef struct {
  sct_hits hits; /* first: make_room gets its address */
  sct_status status;
  sct_error err;
  int64_t copied; /* hits already in the lists */
} part;

typedef struct {
  const sct_search *search;
  double radius;
  const double *radii;
  int64_t limit;
  part *parts; /* [threads] */
  sct_lists *lists;
} listing;

static const int64_t entries_most = (int64_t)1 << 40;

static bool grow(sct_hits *hits, int64_t more) {
  part *mine = (part *)hits;
  int64_t capacity = hits->n + more + hits->capacity / 2;
  mine->status = sct_realloc(&hits->index, capacity, sizeof *hits->index, &mine->err);
  if (mine->status == SCT_OK) hits->capacity = capacity;
  return mine->status == SCT_OK;
}

/* The neighbours of the points at some places; their number goes to start[point + 1]. */
static bool list_slice(void *context, int64_t first, int64_t last, int t) {
  const listing *l = context;
  const sct_search *search = l->search;
  part *mine = &l->parts[t];
  sct_hits *hits = &mine->hits;
  for (int64_t p = first; p < last; p++) {
    int32_t i = search->order[p];
    double radius = l->radii != NULL ? l->radii[i] : l->radius;
    sct_query query = ask_at(search, p, radius * search->scale);
    int64_t before = hits->n;
    hits->most = before + l->limit;
    search->kind->collect(search, &query, hits);
    if (mine->status == SCT_OK && hits->n > hits->most) {
      mine->status = sct_fail(&mine->err, SCT_E_LIMIT, i,
                              "has more than %" PRId64 " neighbours within %g", l->limit, radius);
    }
    if (mine->status == SCT_OK && hits->n > entries_most) {
      mine->status = sct_fail(&mine->err, SCT_E_LIMIT, i, "there are more than 2^40 neighbours");
    }
    if (mine->status != SCT_OK) return false;
    l->lists->start[i + 1] = hits->n - before;
  }
  return true;
}

/* Copies the hits of a slice, which come in the order of places, to the rows of their points. */
static bool copy_slice(void *context, int64_t first, int64_t last, int t) {
  const listing *l = context;
  part *mine = &l->parts[t];
  for (int64_t p = first; p < last; p++) {
    int32_t i = l->search->order[p];
    int64_t start = l->lists->start[i], n = l->lists->start[i + 1] - start;
    if (n == 0) continue;
    memcpy(l->lists->index + start, mine->hits.index + mine->copied, (size_t)n * sizeof(int32_t));
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
  bool failed = false;
  sct_status status = in_pieces(lists->n, work, "neighbours", list_slice, l, &failed, err);
  if (status != SCT_OK) return status;
  if (failed) return first_failure(l, err);
  for (int64_t i = 0; i < lists->n; i++) lists->start[i + 1] += lists->start[i];
  status = sct_alloc(&lists->index, lists->start[lists->n], sizeof(int32_t), err);
  if (status != SCT_OK) return status;
  return in_pieces(lists->n, work, "neighbour lists", copy_slice, l, &failed, err);
}

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
  for (int t = 0; t < threads; t++) l.parts[t].hits.make_room = grow;
  l.lists->n = search->n;
  status = sct_alloc_zero(&l.lists->start, search->n + 1, sizeof *l.lists->start, err);
  if (status == SCT_OK) status = list_all(&l, work, err);
done:
  for (int t = 0; l.parts != NULL && t < threads; t++) sct_release(&l.parts[t].hits.index);
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

/* -- around -------------------------------------------------------------------------------------
 */

/* Hits on their way to memory of fixed size. */
typedef struct {
  sct_hits hits; /* first: make_room gets its address */
  int32_t block[2 * SCT_SCAN_BLOCK];
  int32_t *out; /* [capacity] */
  int64_t capacity, n;
} funnel;

static bool pour(sct_hits *hits, int64_t more) {
  (void)more;
  funnel *f = (funnel *)hits;
  int64_t room = f->n < f->capacity ? f->capacity - f->n : 0;
  int64_t kept = hits->n < room ? hits->n : room;
  if (kept > 0) memcpy(f->out + f->n, f->block, (size_t)kept * sizeof *f->out);
  f->n += hits->n;
  hits->n = 0;
  return true;
}

static int64_t ask(const sct_search *search, const sct_query *query, int64_t capacity,
                   int32_t *index) {
  funnel f = {.out = index, .capacity = capacity, .n = 0};
  f.hits = (sct_hits){f.block, 0, 2 * SCT_SCAN_BLOCK, INT64_MAX, pour};
  search->kind->collect(search, query, &f.hits);
  pour(&f.hits, 0);
  return f.n;
}

int64_t sct_search_around(const sct_search *search, const double *x, double radius,
                          int64_t capacity, int32_t *index) {
  if (!(radius > 0)) return 0;
  radius *= search->scale;
  sct_query query = {.radius = radius, .square = radius * radius, .self = -1};
  for (int k = 0; k < search->dim; k++) query.x[k] = x[k] * search->scale;
  return ask(search, &query, capacity, index);
}

/* -- nearest ------------------------------------------------------------------------------------
 */

typedef struct {
  const sct_search *search;
  double *distance;
} distances;

static bool nearest_slice(void *context, int64_t first, int64_t last, int t) {
  (void)t;
  const distances *d = context;
  const sct_search *search = d->search;
  for (int64_t p = first; p < last; p++) {
    sct_query query = ask_at(search, p, 0);
    d->distance[search->order[p]] = sqrt(search->kind->nearest(search, &query)) / search->scale;
  }
  return true;
}

/* Smallest number above `after` of a point where point i is; -1: none. */
static int64_t company(const sct_search *search, int64_t i, int64_t after) {
  int64_t place = 0, found = -1;
  while (search->order[place] != i) place++;
  sct_query query = ask_at(search, place, 0);
  for (int64_t p = 0; p < search->n; p++) {
    int64_t j = search->order[p];
    bool lower = j > after && (found < 0 || j < found);
    if (lower && sct_square(search, search->dim, query.x, p) == 0) found = j;
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
  distances d = {search, distance};
  bool failed = false;
  sct_status status =
      in_pieces(search->n, work, "nearest neighbours", nearest_slice, &d, &failed, err);
  for (int64_t i = 0; i < search->n && status == SCT_OK; i++) {
    if (distance[i] == 0) status = coincident(search, distance, i, err);
  }
  return status;
}

/* -- median -------------------------------------------------------------------------------------
 */

/* Radix selection: the digits of the median's key are fixed one after the other, the highest
 * first, by counting the values that share the digits fixed so far. No memory, no bad case. */
sct_status sct_median(const double *value, int64_t n, double *median, sct_error *err) {
  enum { DIGIT = 8, BUCKETS = 1 << DIGIT };
  if (n < 1) return sct_fail(err, SCT_E_ARGUMENT, -1, "there is no median of no values");
  uint64_t prefix = 0;
  int64_t rank = (n - 1) / 2;
  for (int shift = 64 - DIGIT; shift >= 0; shift -= DIGIT) {
    int64_t count[BUCKETS] = {0};
    for (int64_t i = 0; i < n; i++) {
      uint64_t key = sct_radix_key(value[i]) >> shift;
      if (key >> DIGIT == prefix) count[key & (BUCKETS - 1)]++;
    }
    uint64_t digit = 0;
    while (rank >= count[digit]) rank -= count[digit++];
    prefix = prefix << DIGIT | digit;
  }
  *median = sct_radix_value(prefix);
  return SCT_OK;
}
