/* search_kind.h - what cells and tree have in common: sorted points, runs, the distance test.
 *
 * Both structures put the points into an order of their own in which the points near any place
 * are a few runs [first, last) of consecutive points. A structure knows which runs may hold an
 * answer; the distance test over a run is the same code for both, so they agree to the last bit.
 * "Place" is a number in the sorted order, "point" a number of the caller's cloud.
 */
#ifndef SCATTER_SEARCH_KIND_H
#define SCATTER_SEARCH_KIND_H

#include "scatter/search.h"

/* Who is near x? Lengths are those of the cloud times sct_search.scale. */
typedef struct {
  double x[SCT_DIM_MAX];
  double radius, square; /* square = radius * radius */
  int64_t self;          /* place that is not asked for, or -1 */
} sct_query;

/* The points found, in the order they were found. */
typedef struct sct_hits sct_hits;
struct sct_hits {
  int32_t *index; /* [capacity] */
  int64_t n, capacity;
  int64_t most;                                    /* the question ends when n is beyond this */
  bool (*make_room)(sct_hits *hits, int64_t more); /* capacity - n >= more; false: none left */
};

/* Cells of one side: point x is in cell (i, j, k) = floor((x - lower) per_length), number
 * c = i + count[0] (j + count[1] k), which holds the places start[c] .. start[c+1]-1. */
typedef struct {
  double lower[SCT_DIM_MAX];
  double side, per_length; /* per_length = 1 / side */
  int64_t count[SCT_DIM_MAX];
  int32_t *start;  /* [cells + 1] */
  double crowding; /* mean over the points of the number of points in the cell of the point */
} sct_cells;

/* Complete binary tree: node m has the children 2 m and 2 m + 1, the root is 1, and node j of
 * level l (m = 2^l + j) holds the places n j / 2^l .. n (j + 1) / 2^l - 1. */
typedef struct {
  int depth;   /* level of the leaves */
  double *box; /* [2^(depth+1)][2][dim] tight lower and upper corner of a node's points */
} sct_tree;

/* The methods of a structure. `search` has dim, n and scale when build is called, and x sorted by
 * `order` (which build fills) afterwards. */
typedef struct {
  sct_search_method method;
  const char *name;
  sct_status (*build)(sct_search *search, const sct_cloud *cloud, double radius, sct_error *err);
  void (*clear)(sct_search *search);
  /* Appends the points closer than query->radius. */
  void (*collect)(const sct_search *search, const sct_query *query, sct_hits *hits);
  /* Square of the distance from place query->self to the nearest other place. */
  double (*nearest)(const sct_search *search, const sct_query *query);
} sct_search_kind_of;

extern const sct_search_kind_of sct_search_grid, sct_search_tree;

struct sct_search {
  const sct_search_kind_of *kind;
  int dim;
  int64_t n;
  double scale;           /* a power of two that brings the cloud into the range of squares */
  double *x[SCT_DIM_MAX]; /* [dim][n] sorted coordinates times scale */
  int32_t *order;         /* [n] point at a place */
  sct_cells cells;        /* of the grid */
  sct_tree tree;          /* of the tree */
};

/* Tested at a time: bounds what is reserved ahead of the test. */
enum { SCT_SCAN_BLOCK = 1024 };

#if defined(__GNUC__)
#define SCT_INLINE static inline __attribute__((always_inline))
#else
#define SCT_INLINE static inline
#endif

SCT_INLINE double sct_square(const sct_search *search, int dim, const double *x, int64_t place) {
  double dx = search->x[0][place] - x[0];
  if (dim == 1) return dx * dx;
  double dy = search->x[1][place] - x[1];
  if (dim == 2) return dx * dx + dy * dy;
  double dz = search->x[2][place] - x[2];
  return dx * dx + dy * dy + dz * dz;
}

/* Writes the points of [first, last) that are hit to out; returns how many. Writing each one and
 * counting it only if it is a hit costs no branch, and needs room for last - first. */
SCT_INLINE int64_t sct_scan(const sct_search *search, int dim, const sct_query *query,
                            int64_t first, int64_t last, int32_t *restrict out) {
  int64_t m = 0;
  for (int64_t p = first; p < last; p++) {
    out[m] = search->order[p];
    m += sct_square(search, dim, query->x, p) < query->square;
  }
  return m;
}

/* What is done with a run. False: stop asking. */
typedef bool sct_visit(const sct_search *search, int dim, const sct_query *query, int64_t first,
                       int64_t last, void *into);

/* Appends the hits of a run without query->self. */
SCT_INLINE bool sct_collect_part(const sct_search *search, int dim, const sct_query *query,
                                 int64_t first, int64_t last, sct_hits *hits) {
  while (first < last) {
    int64_t next = last - first > SCT_SCAN_BLOCK ? first + SCT_SCAN_BLOCK : last;
    if (hits->capacity - hits->n < next - first && !hits->make_room(hits, next - first)) {
      return false;
    }
    hits->n += sct_scan(search, dim, query, first, next, hits->index + hits->n);
    if (hits->n > hits->most) return false;
    first = next;
  }
  return true;
}

/* Appends the hits of a run to an sct_hits. */
SCT_INLINE bool sct_visit_collect(const sct_search *search, int dim, const sct_query *query,
                                  int64_t first, int64_t last, void *into) {
  int64_t self = query->self;
  if (self < first || self >= last) {
    return sct_collect_part(search, dim, query, first, last, into);
  }
  return sct_collect_part(search, dim, query, first, self, into) &&
         sct_collect_part(search, dim, query, self + 1, last, into);
}

/* Lowers a double to the smallest square of a distance from query->x to a point of a run. */
SCT_INLINE bool sct_visit_nearest(const sct_search *search, int dim, const sct_query *query,
                                  int64_t first, int64_t last, void *into) {
  double best = *(double *)into;
  for (int64_t p = first; p < last; p++) {
    double square = sct_square(search, dim, query->x, p);
    if (square < best && p != query->self) best = square;
  }
  *(double *)into = best;
  return true;
}

#endif
