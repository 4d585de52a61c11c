/* Uniform cells. The points are sorted by cell, x fastest, so that the cells of one line along x
 * are one run of places: a ball is a handful of runs, each cut to the width of the ball at that
 * line. The side of the cells does not bind the radius of a question.
 */
#include <math.h>
#include <string.h>

#include "alloc.h"
#include "search_kind.h"

/* Points per cell aimed at: measured to be within 10 % of the best for radii of 1 to 4 spacings in
 * two and three dimensions, so the radius of the questions need not be known. */
static const double filling = 8;

/* Cells per point at most, for clouds that leave much of their box empty; and cells, whose numbers
 * are int32_t: up to 8 times as many as wanted are laid out. */
static const double cells_per_point = 4, cells_most = 1 << 27;

static int longer_first(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x < y) - (x > y);
}

/* Side s of about `wanted` cells on a box of extents L_1 >= L_2 >= ...: s_m = (L_1 ... L_m /
 * wanted)^(1/m) with m such that the other extents are shorter than s_m, one cell wide. If
 * L_(m+1) > s_m then s_m < s_(m+1) < L_(m+1), so axes are taken in as long as they are longer. */
static double side_of(const double *extent, double wanted) {
  double l[SCT_DIM_MAX];
  memcpy(l, extent, sizeof l);
  qsort(l, SCT_DIM_MAX, sizeof *l, longer_first);
  if (!(l[0] > 0)) return 1; /* all points at one place */
  double side = l[0] / wanted;
  for (int m = 1; m < SCT_DIM_MAX && l[m] > side; m++) side *= pow(l[m] / side, 1.0 / (m + 1));
  return isfinite(1 / side) ? side : 1; /* else too small to divide by: one cell */
}

static sct_status lay_out(sct_search *search, double wanted, sct_error *err) {
  sct_cells *cells = &search->cells;
  double extent[SCT_DIM_MAX];
  for (int k = 0; k < SCT_DIM_MAX; k++) extent[k] = search->box.upper[k] - search->box.lower[k];
  cells->side = side_of(extent, wanted);
  cells->per_length = 1 / cells->side;
  search->step = cells->side;
  int64_t all = 1;
  for (int k = 0; k < SCT_DIM_MAX; k++) {
    cells->lower[k] = search->box.lower[k];
    cells->count[k] = (int64_t)(extent[k] * cells->per_length) + 1;
    all *= cells->count[k];
  }
  return sct_alloc_zero(&cells->start, all + 1, sizeof *cells->start, err);
}

/* Cell along an axis of a place measured in cells; the outermost cells reach to infinity. */
static int64_t cell_at(double cells, int64_t count) {
  double last = (double)(count - 1);
  return cells > 0 ? (int64_t)(cells < last ? cells : last) : 0;
}

static int32_t cell_of(const sct_cells *cells, int dim, double scale, const double *x) {
  int64_t c = 0;
  for (int k = dim - 1; k >= 0; k--) {
    // NOLINTNEXTLINE(clang-analyzer-core.UndefinedBinaryOperatorResult): dim is at most 3
    double place = (x[k] * scale - cells->lower[k]) * cells->per_length;
    c = c * cells->count[k] + cell_at(place, cells->count[k]);
  }
  return (int32_t)c;
}

/* cell [n] of the points, their numbers in start[cell], and the crowding. */
static void count(sct_search *search, const sct_cloud *cloud, int32_t *cell) {
  sct_cells *cells = &search->cells;
  double pairs = 0; /* of points in the same cell, by (m + 1)^2 - m^2 = 2 m + 1 */
  for (int64_t i = 0; i < cloud->n; i++) {
    cell[i] = cell_of(cells, cloud->dim, search->scale, cloud->x + i * cloud->dim);
    pairs += 2 * cells->start[cell[i]]++ + 1;
  }
  cells->crowding = pairs / (double)cloud->n;
}

/* Lays out cells that are not crowded, as far as that can be had by more of them. */
static sct_status fit(sct_search *search, const sct_cloud *cloud, int32_t *cell, sct_error *err) {
  const double n = (double)cloud->n, most = fmin(cells_per_point * n, cells_most);
  const double expected = filling + 1; /* of a random cloud */
  double wanted = fmin(fmax(n / filling, 1), most);
  for (;;) {
    sct_status status = lay_out(search, wanted, err);
    if (status != SCT_OK) return status;
    count(search, cloud, cell);
    if (search->cells.crowding <= 2 * expected || wanted >= most) return SCT_OK;
    wanted = fmin(wanted * search->cells.crowding / expected, most);
    sct_release(&search->cells.start);
  }
}

/* Counting sort, from the back, so that the points of a cell stay in their order. */
static void sort(sct_search *search, const int32_t *cell) {
  sct_cells *cells = &search->cells;
  int64_t all = cells->count[0] * cells->count[1] * cells->count[2];
  int32_t end = 0;
  for (int64_t c = 0; c < all; c++) cells->start[c] = end += cells->start[c];
  cells->start[all] = end;
  for (int64_t i = search->n - 1; i >= 0; i--) search->order[--cells->start[cell[i]]] = (int32_t)i;
}

static sct_status build(sct_search *search, const sct_cloud *cloud, sct_error *err) {
  int32_t *cell = NULL;
  sct_status status = sct_alloc(&cell, cloud->n, sizeof *cell, err);
  if (status == SCT_OK) status = fit(search, cloud, cell, err);
  if (status == SCT_OK) sort(search, cell);
  sct_release(&cell);
  return status;
}

static void clear(sct_search *search) {
  sct_release(&search->cells.start);
}

/* A box in the units of the cells, and how far around it to look: far enough for every rounding
 * on the way there, so the runs may hold too much, never too little. */
typedef struct {
  sct_box box;
  double radius, slack;
} reach;

static double clamp(double value, double lower, double upper) {
  value = value > lower ? value : lower;
  return value < upper ? value : upper;
}

static reach reach_of(const sct_cells *cells, const sct_box *box, double radius) {
  const double far = 1e149; /* squares are finite; moving a box closer only adds cells */
  reach r = {.slack = 1e-5};
  for (int k = 0; k < SCT_DIM_MAX; k++) {
    double lower = (box->lower[k] - cells->lower[k]) * cells->per_length;
    double upper = (box->upper[k] - cells->lower[k]) * cells->per_length;
    r.box.lower[k] = clamp(lower, -far, far);
    r.box.upper[k] = clamp(upper, -far, far);
    r.slack += 1e-14 * (fabs(r.box.lower[k]) + fabs(r.box.upper[k]));
  }
  r.radius = clamp(radius * cells->per_length * (1 + 1e-12) + r.slack, 0, 10 * far);
  return r;
}

typedef struct {
  int64_t first, last;
} range;

/* Rows of cells along axis k within reach. */
static range rows(const sct_cells *cells, const reach *r, int k) {
  range rows = {cell_at(r->box.lower[k] - r->radius, cells->count[k]),
                cell_at(r->box.upper[k] + r->radius, cells->count[k])};
  return rows;
}

/* What the gap between the box and `row` of axis k leaves of the square of a radius. */
static double left_over(const reach *r, int k, int64_t row, double square) {
  double below = (double)row - r->box.upper[k], above = r->box.lower[k] - (double)(row + 1);
  double gap = (below > above ? below : above) - r->slack;
  return gap > 0 ? square - gap * gap : square;
}

/* Places of the cells of line (y, z) less than `radius` before or behind the box. */
static range run_of(const sct_cells *cells, const reach *r, int64_t y, int64_t z, double radius) {
  const int32_t *line = cells->start + (z * cells->count[1] + y) * cells->count[0];
  range run = {line[cell_at(r->box.lower[0] - radius, cells->count[0])],
               line[cell_at(r->box.upper[0] + radius, cells->count[0]) + 1]};
  return run;
}

static void walk(const sct_search *search, const sct_box *box, double radius, sct_visit *visit,
                 void *into) {
  const sct_cells *cells = &search->cells;
  reach r = reach_of(cells, box, radius);
  range ys = rows(cells, &r, 1), zs = rows(cells, &r, 2);
  for (int64_t z = zs.first; z <= zs.last; z++) {
    double square_z = left_over(&r, 2, z, r.radius * r.radius);
    if (square_z < 0) continue;
    for (int64_t y = ys.first; y <= ys.last; y++) {
      double square = left_over(&r, 1, y, square_z);
      if (square < 0) continue;
      range run = run_of(cells, &r, y, z, sqrt(square));
      if (run.first < run.last && !visit(into, run.first, run.last)) return;
    }
  }
}

/* The cell's end. */
static int64_t bundle_end(const sct_search *search, int64_t place) {
  const sct_cells *cells = &search->cells;
  double x[SCT_DIM_MAX];
  for (int k = 0; k < search->dim; k++) x[k] = search->x[k][place];
  return cells->start[cell_of(cells, search->dim, 1, x) + 1];
}

const sct_search_kind_of sct_search_grid = {
    SCT_SEARCH_GRID, "grid", build, clear, walk, bundle_end,
};
