/* A k-d tree for clouds that cells cannot hold. The points are sorted once along every axis; a
 * node is then the same range of all these orders, its box can be read off their ends, and it is
 * split at the median of the axis it is longest in by a stable partition of the other orders. So
 * the build is O(n log n) whatever the input is (a selection by pivots is not, and ties and
 * clusters need care there), and without recursion.
 */
#include <math.h>
#include <string.h>

#include "alloc.h"
#include "radix.h"
#include "search_kind.h"

enum { LEAF = 12 /* points of a leaf, at most */, LEVELS = 32 };

typedef struct {
  int32_t *order[SCT_DIM_MAX]; /* [dim][n] points by coordinate, within every node */
  uint8_t *right;              /* [n] is this point in the right half of its node? */
  int32_t *spare;              /* [n] */
} sorted;

typedef struct {
  int64_t first, last;
} range;

static int level_of(int64_t m) {
  int level = 0;
  while (m >> (level + 1) != 0) level++;
  return level;
}

/* Places of node m of a level. */
static range node_places(int64_t n, int level, int64_t m) {
  int64_t j = m - ((int64_t)1 << level);
  range r = {n * j >> level, n * (j + 1) >> level};
  return r;
}

/* -- build ------------------------------------------------------------------------------------- */

static sct_status sort_axis(const sct_cloud *cloud, int k, uint64_t *key, int32_t *order,
                            sct_error *err) {
  for (int64_t i = 0; i < cloud->n; i++) key[i] = sct_radix_key(cloud->x[i * cloud->dim + k]);
  return sct_radix_sort(key, cloud->n, 64, order, err);
}

/* Fills the box of node m; returns the axis it is longest in. */
static int bound(sct_search *search, const sct_cloud *cloud, const sorted *s, int64_t m, range r) {
  int dim = cloud->dim, longest = 0;
  double *lower = search->tree.box + m * 2 * dim, *upper = lower + dim;
  for (int k = 0; k < dim; k++) {
    lower[k] = cloud->x[(int64_t)s->order[k][r.first] * dim + k] * search->scale;
    upper[k] = cloud->x[(int64_t)s->order[k][r.last - 1] * dim + k] * search->scale;
    if (upper[k] - lower[k] > upper[longest] - lower[longest]) longest = k;
  }
  return longest;
}

/* Moves the points of the right half behind the others; both keep their order. */
static void partition(int32_t *order, range r, const uint8_t *right, int32_t *spare) {
  int64_t left = r.first, moved = 0;
  for (int64_t q = r.first; q < r.last; q++) {
    int32_t i = order[q];
    order[left] = i;
    spare[moved] = i;
    left += !right[i];
    moved += right[i];
  }
  memcpy(order + left, spare, (size_t)moved * sizeof *order);
}

static void split(sorted *s, int dim, int axis, range r, int64_t middle) {
  for (int64_t q = r.first; q < r.last; q++) s->right[s->order[axis][q]] = q >= middle;
  for (int k = 0; k < dim; k++) {
    if (k != axis) partition(s->order[k], r, s->right, s->spare);
  }
}

static void grow(sct_search *search, const sct_cloud *cloud, sorted *s) {
  int64_t leaves = (int64_t)1 << search->tree.depth;
  for (int64_t m = 1; m < 2 * leaves; m++) {
    int level = level_of(m);
    range r = node_places(search->n, level, m);
    int axis = bound(search, cloud, s, m, r);
    if (m >= leaves) continue;
    split(s, cloud->dim, axis, r, node_places(search->n, level + 1, 2 * m).last);
  }
}

/* Short rather than long: a search doubles it. */
static double step_of(const sct_search *search) {
  double longest = 0;
  for (int k = 0; k < search->dim; k++) {
    longest = fmax(longest, search->box.upper[k] - search->box.lower[k]);
  }
  return longest > 0 ? longest / (double)search->n : 1;
}

static sct_status build(sct_search *search, const sct_cloud *cloud, sct_error *err) {
  sorted s = {.order = {search->order}};
  uint64_t *key = NULL;
  search->step = step_of(search);
  search->tree.depth = 0;
  while (cloud->n >> search->tree.depth > LEAF) search->tree.depth++;
  sct_status status = sct_alloc(&search->tree.box, (int64_t)2 << search->tree.depth,
                                2 * (size_t)cloud->dim * sizeof(double), err);
  if (status == SCT_OK) status = sct_alloc(&key, cloud->n, sizeof *key, err);
  for (int k = 0; k < cloud->dim && status == SCT_OK; k++) {
    if (k > 0) status = sct_alloc(&s.order[k], cloud->n, sizeof(int32_t), err);
    if (status == SCT_OK) status = sort_axis(cloud, k, key, s.order[k], err);
  }
  sct_release(&key);
  if (status == SCT_OK) status = sct_alloc(&s.right, cloud->n, sizeof *s.right, err);
  if (status == SCT_OK) status = sct_alloc(&s.spare, cloud->n, sizeof *s.spare, err);
  if (status == SCT_OK) grow(search, cloud, &s);
  for (int k = 1; k < cloud->dim; k++) sct_release(&s.order[k]);
  sct_release(&s.right);
  sct_release(&s.spare);
  return status;
}

static void clear(sct_search *search) {
  sct_release(&search->tree.box);
}

/* -- questions --------------------------------------------------------------------------------- */

/* Square of the distance between a box and that of a node. Rounding is monotonic and the
 * operations are those of the distance test, so no two points of them test closer than this. */
static double near_square(int dim, const double *lower, const sct_box *box) {
  const double *upper = lower + dim;
  double sum = 0;
  for (int k = 0; k < dim; k++) {
    double behind = lower[k] - box->upper[k], before = box->lower[k] - upper[k];
    double gap = behind > 0 ? behind : before > 0 ? before : 0;
    sum += gap * gap;
  }
  return sum;
}

/* Square of the largest distance: no two points test farther apart. */
static double far_square(int dim, const double *lower, const sct_box *box) {
  const double *upper = lower + dim;
  double sum = 0;
  for (int k = 0; k < dim; k++) {
    double gap = fmax(upper[k] - box->lower[k], box->upper[k] - lower[k]);
    sum += gap * gap;
  }
  return sum;
}

/* Visits the nodes within reach from left to right; a node that is wholly within is one run. */
static void walk(const sct_search *search, const sct_box *box, double radius, sct_visit *visit,
                 void *into) {
  const int64_t leaves = (int64_t)1 << search->tree.depth;
  const double square = radius * radius;
  int64_t stack[LEVELS], *top = stack;
  *top++ = 1;
  while (top > stack) {
    int64_t m = *--top;
    const double *lower = search->tree.box + m * 2 * search->dim;
    if (!(near_square(search->dim, lower, box) < square)) continue;
    if (m < leaves && !(far_square(search->dim, lower, box) < square)) {
      *top++ = 2 * m + 1;
      *top++ = 2 * m;
      continue;
    }
    range r = node_places(search->n, m < leaves ? level_of(m) : search->tree.depth, m);
    if (!visit(into, r.first, r.last)) return;
  }
}

/* The leaf's end. */
static int64_t bundle_end(const sct_search *search, int64_t place) {
  const int depth = search->tree.depth;
  int64_t leaf = (place << depth) / search->n;
  while (search->n * (leaf + 1) >> depth <= place) leaf++;
  return search->n * (leaf + 1) >> depth;
}

const sct_search_kind_of sct_search_tree = {
    SCT_SEARCH_TREE, "tree", build, clear, walk, bundle_end,
};
