/* Uniform cells. The points are sorted by cell, x fastest, so that the cells of one line along x
 * are one run of places: a ball is a handful of runs, each cut to the width of the ball at that
 * line. The side of the cells does not bind the radius of a question.
 */
#include <math.h>

#include "alloc.h"
#include "search_kind.h"

/* Points per cell aimed at. */
static const double filling = 2;

/* Up to 8 times as many cells are laid out; their numbers are int32_t. */
static const double cells_most = 1 << 27;

/* Corners of the scaled cloud. */
static void corners(const sct_cloud *cloud, double scale, double *lower, double *upper) {
  int dim = cloud->dim;
  for (int k = 0; k < dim; k++) lower[k] = upper[k] = cloud->x[k];
  for (const double *x = cloud->x; x < cloud->x + cloud->n * dim; x += dim) {
    for (int k = 0; k < dim; k++) {
      if (x[k] < lower[k]) lower[k] = x[k];
      if (x[k] > upper[k]) upper[k] = x[k];
    }
  }
  for (int k = 0; k < dim; k++) {
    lower[k] *= scale;
    upper[k] *= scale;
  }
}

static int longer_first(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x < y) - (x > y);
}

/* Side s of about `wanted` cells on a box of extents L_1 >= L_2 >= ...: s_m = (L_1 ... L_m /
 * wanted)^(1/m) with m such that the other extents are shorter than s_m, one cell wide. If
 * L_(m+1) > s_m then s_m < s_(m+1) < L_(m+1), so axes are taken in as long as they are longer. */
static double side_of(int dim, const double *extent, double wanted) {
  double l[SCT_DIM_MAX] = {0};
  for (int k = 0; k < dim; k++) l[k] = extent[k];
  qsort(l, (size_t)dim, sizeof *l, longer_first);
  if (!(l[0] > 0)) return 1; /* all points at one place */
  double side = l[0] / wanted;
  for (int m = 1; m < dim && l[m] > side; m++) side *= pow(l[m] / side, 1.0 / (m + 1));
  return isfinite(1 / side) ? side : 1; /* else too small to divide by: one cell */
}

static sct_status lay_out(sct_cells *cells, const sct_cloud *cloud, double scale, sct_error *err) {
  double upper[SCT_DIM_MAX], extent[SCT_DIM_MAX] = {0};
  corners(cloud, scale, cells->lower, upper);
  for (int k = 0; k < cloud->dim; k++) extent[k] = upper[k] - cells->lower[k];
  double wanted = fmin(fmax((double)cloud->n / filling, 1), cells_most);
  cells->side = side_of(cloud->dim, extent, wanted);
  cells->per_length = 1 / cells->side;
  int64_t all = 1;
  for (int k = 0; k < SCT_DIM_MAX; k++) {
    cells->count[k] = (int64_t)(extent[k] * cells->per_length) + 1;
    all *= cells->count[k];
  }
  return sct_alloc_zero(&cells->start, all + 1, sizeof *cells->start, err);
}

/* Cell along an axis of a place measured in cells; the outermost cells reach to infinity. */
SCT_INLINE int64_t cell_at(double cells, int64_t count) {
  double last = (double)(count - 1);
  return cells > 0 ? (int64_t)(cells < last ? cells : last) : 0;
}

static int32_t cell_of(const sct_cells *cells, int dim, double scale, const double *x) {
  int64_t c = 0;
  for (int k = dim - 1; k >= 0; k--) {
    double place = (x[k] * scale - cells->lower[k]) * cells->per_length;
    c = c * cells->count[k] + cell_at(place, cells->count[k]);
  }
  return (int32_t)c;
}

/* Turns the numbers of points start[c] into the places after the last point of each cell. */
static void sum_up(sct_cells *cells, int64_t n) {
  int64_t all = cells->count[0] * cells->count[1] * cells->count[2], sum = 0;
  double squares = 0;
  for (int64_t c = 0; c < all; c++) {
    squares += (double)cells->start[c] * cells->start[c];
    sum += cells->start[c];
    cells->start[c] = (int32_t)sum;
  }
  cells->start[all] = (int32_t)sum;
  cells->crowding = squares / (double)n;
}

/* Counting sort, from the back, so that the points of a cell stay in their order. */
static sct_status build(sct_search *search, const sct_cloud *cloud, double radius, sct_error *err) {
  (void)radius;
  sct_cells *cells = &search->cells;
  int dim = cloud->dim;
  int32_t *cell = NULL;
  sct_status status = lay_out(cells, cloud, search->scale, err);
  if (status == SCT_OK) status = sct_alloc(&cell, cloud->n, sizeof *cell, err);
  if (status != SCT_OK) goto done;
  for (int64_t i = 0; i < cloud->n; i++) {
    cell[i] = cell_of(cells, dim, search->scale, cloud->x + i * dim);
    cells->start[cell[i]]++;
  }
  sum_up(cells, cloud->n);
  for (int64_t i = cloud->n - 1; i >= 0; i--) search->order[--cells->start[cell[i]]] = (int32_t)i;
done:
  sct_release(&cell);
  return status;
}

static void clear(sct_search *search) {
  sct_release(&search->cells.start);
}

/* A ball in the units of the cells, wide enough for every rounding on the way there: the runs may
 * hold too much, never too little. */
typedef struct {
  double x[SCT_DIM_MAX], radius, slack;
} ball;

SCT_INLINE double clamp(double value, double lower, double upper) {
  value = value > lower ? value : lower;
  return value < upper ? value : upper;
}

SCT_INLINE ball ball_of(const sct_cells *cells, int dim, const sct_query *query) {
  const double far = 1e149; /* squares are finite; moving x closer only adds cells */
  ball b = {.slack = 1e-5};
  for (int k = 0; k < dim; k++) {
    b.x[k] = clamp((query->x[k] - cells->lower[k]) * cells->per_length, -far, far);
    b.slack += 1e-14 * fabs(b.x[k]);
  }
  b.radius = clamp(query->radius * cells->per_length * (1 + 1e-12) + b.slack, 0, 10 * far);
  return b;
}

typedef struct {
  int64_t first, last;
} range;

/* Rows of cells along axis k that the ball touches. */
SCT_INLINE range rows(const sct_cells *cells, const ball *b, int dim, int k) {
  range r = {0, 0};
  if (k < dim) {
    r.first = cell_at(b->x[k] - b->radius, cells->count[k]);
    r.last = cell_at(b->x[k] + b->radius, cells->count[k]);
  }
  return r;
}

/* What is left of the square of the ball's half width, `rest`, in `row` of axis k. */
SCT_INLINE double left_over(const ball *b, int dim, int k, int64_t row, double rest) {
  if (k >= dim) return rest;
  double below = (double)row - b->x[k], above = b->x[k] - (double)(row + 1);
  double gap = (below > above ? below : above) - b->slack;
  return gap > 0 ? rest - gap * gap : rest;
}

/* Places of the cells of line (y, z) within half a width of the ball's middle. */
SCT_INLINE range run_of(const sct_cells *cells, const ball *b, int64_t y, int64_t z, double half) {
  const int32_t *line = cells->start + (z * cells->count[1] + y) * cells->count[0];
  range r = {line[cell_at(b->x[0] - half, cells->count[0])],
             line[cell_at(b->x[0] + half, cells->count[0]) + 1]};
  return r;
}

/* Visits the runs of the ball of `query`. */
SCT_INLINE void walk(const sct_search *search, int dim, const sct_query *query, sct_visit *visit,
                     void *into) {
  const sct_cells *cells = &search->cells;
  ball b = ball_of(cells, dim, query);
  range ys = rows(cells, &b, dim, 1), zs = rows(cells, &b, dim, 2);
  for (int64_t z = zs.first; z <= zs.last; z++) {
    double rest_z = left_over(&b, dim, 2, z, b.radius * b.radius);
    if (rest_z < 0) continue;
    for (int64_t y = ys.first; y <= ys.last; y++) {
      double rest = left_over(&b, dim, 1, y, rest_z);
      if (rest < 0) continue;
      range run = run_of(cells, &b, y, z, sqrt(rest));
      if (!visit(search, dim, query, run.first, run.last, into)) return;
    }
  }
}

static void collect(const sct_search *search, const sct_query *query, sct_hits *hits) {
  switch (search->dim) {
    case 1:
      walk(search, 1, query, sct_visit_collect, hits);
      break;
    case 2:
      walk(search, 2, query, sct_visit_collect, hits);
      break;
    default:
      walk(search, 3, query, sct_visit_collect, hits);
  }
}

static void closest(const sct_search *search, const sct_query *query, double *best) {
  switch (search->dim) {
    case 1:
      walk(search, 1, query, sct_visit_nearest, best);
      break;
    case 2:
      walk(search, 2, query, sct_visit_nearest, best);
      break;
    default:
      walk(search, 3, query, sct_visit_nearest, best);
  }
}

/* Asks wider and wider balls until one holds a point. */
static double nearest(const sct_search *search, const sct_query *query) {
  const sct_cells *cells = &search->cells;
  double all = cells->side * (double)(cells->count[0] + cells->count[1] + cells->count[2]);
  double best = INFINITY, r = cells->side;
  sct_query wider = *query;
  for (;; r *= 2) {
    wider.radius = r;
    closest(search, &wider, &best);
    if (best <= r * r || r > all) break;
  }
  return best;
}

const sct_search_kind_of sct_search_grid = {
    SCT_SEARCH_GRID, "grid", build, clear, collect, nearest,
};
