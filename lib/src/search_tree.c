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

static const double *lower_of(const sct_search *search, int dim, int64_t m) {
  return search->tree.box + m * 2 * dim;
}

/* -- build --------------------------------------------------------------------------------------
 */

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

static sct_status build(sct_search *search, const sct_cloud *cloud, double radius, sct_error *err) {
  (void)radius;
  sorted s = {.order = {search->order}};
  uint64_t *key = NULL;
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

/* -- questions ----------------------------------------------------------------------------------
 */

SCT_INLINE double sum_of_squares(int dim, const double *d) {
  if (dim == 1) return d[0] * d[0];
  if (dim == 2) return d[0] * d[0] + d[1] * d[1];
  return d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
}

/* Square of the distance from x to the nearest place of a box. Rounding is monotonic and the
 * operations are those of the distance test, so no point of the box tests closer than this. */
SCT_INLINE double box_square(int dim, const double *lower, const double *x) {
  const double *upper = lower + dim;
  double gap[SCT_DIM_MAX];
  for (int k = 0; k < dim; k++) {
    double below = lower[k] - x[k], above = x[k] - upper[k];
    gap[k] = below > 0 ? below : above > 0 ? above : 0;
  }
  return sum_of_squares(dim, gap);
}

/* Square of the distance from x to the farthest corner: no point tests farther. */
SCT_INLINE double corner_square(int dim, const double *lower, const double *x) {
  const double *upper = lower + dim;
  double gap[SCT_DIM_MAX];
  for (int k = 0; k < dim; k++) gap[k] = fmax(fabs(lower[k] - x[k]), fabs(upper[k] - x[k]));
  return sum_of_squares(dim, gap);
}

/* Visits the nodes that the ball touches from left to right; a node that lies in the ball is one
 * run. */
SCT_INLINE void walk(const sct_search *search, int dim, const sct_query *query, sct_hits *hits) {
  const int64_t leaves = (int64_t)1 << search->tree.depth;
  int64_t stack[LEVELS], *top = stack;
  *top++ = 1;
  while (top > stack) {
    int64_t m = *--top;
    const double *lower = lower_of(search, dim, m);
    if (!(box_square(dim, lower, query->x) < query->square)) continue;
    if (m < leaves && !(corner_square(dim, lower, query->x) < query->square)) {
      *top++ = 2 * m + 1;
      *top++ = 2 * m;
      continue;
    }
    range r = node_places(search->n, m < leaves ? level_of(m) : search->tree.depth, m);
    if (!sct_visit_collect(search, dim, query, r.first, r.last, hits)) return;
  }
}

/* Visits the nearer child first, and no node farther than the best so far. */
SCT_INLINE double descend(const sct_search *search, int dim, const sct_query *query) {
  const int64_t leaves = (int64_t)1 << search->tree.depth;
  struct {
    int64_t m;
    double square;
  } stack[LEVELS], *top = stack;
  double best = INFINITY;
  top->m = 1;
  top++->square = 0;
  while (top > stack) {
    int64_t m = (--top)->m;
    if (top->square >= best) continue;
    if (m >= leaves) {
      range r = node_places(search->n, search->tree.depth, m);
      sct_visit_nearest(search, dim, query, r.first, r.last, &best);
      continue;
    }
    double left = box_square(dim, lower_of(search, dim, 2 * m), query->x);
    double right = box_square(dim, lower_of(search, dim, 2 * m + 1), query->x);
    bool right_first = right < left;
    top->m = 2 * m + !right_first;
    top++->square = right_first ? left : right;
    top->m = 2 * m + right_first;
    top++->square = right_first ? right : left;
  }
  return best;
}

static void collect(const sct_search *search, const sct_query *query, sct_hits *hits) {
  switch (search->dim) {
    case 1:
      walk(search, 1, query, hits);
      break;
    case 2:
      walk(search, 2, query, hits);
      break;
    default:
      walk(search, 3, query, hits);
  }
}

static double nearest(const sct_search *search, const sct_query *query) {
  switch (search->dim) {
    case 1:
      return descend(search, 1, query);
    case 2:
      return descend(search, 2, query);
    default:
      return descend(search, 3, query);
  }
}

const sct_search_kind_of sct_search_tree = {
    SCT_SEARCH_TREE, "tree", build, clear, collect, nearest,
};
