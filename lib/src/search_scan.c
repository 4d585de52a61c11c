#include "search_scan.h"

#include <math.h>

#if defined(__GNUC__) && defined(__x86_64__)
#define WIDE 1
#include <immintrin.h>
#else
#define WIDE 0
#endif

#define BY_DIM(dim, f, ...) \
  ((dim) == 1 ? f(1, __VA_ARGS__) : (dim) == 2 ? f(2, __VA_ARGS__) : f(3, __VA_ARGS__))

void sct_scan_close(sct_scan *scan) {
  for (int64_t j = scan->n; j < scan->n + SCT_SCAN_PAD; j++) {
    for (int k = 0; k < SCT_DIM_MAX; k++) scan->x[k][j] = NAN;
    scan->point[j] = -1;
  }
}

/* -- any machine ------------------------------------------------------------------------------- */

static inline double square_of(int dim, const sct_scan *scan, const double *x, int64_t j) {
  double dx = scan->x[0][j] - x[0];
  if (dim == 1) return dx * dx;
  double dy = scan->x[1][j] - x[1];
  if (dim == 2) return dx * dx + dy * dy;
  double dz = scan->x[2][j] - x[2];
  return dx * dx + dy * dy + dz * dz;
}

/* Every point is written, and counted if it is a hit: no branch to be guessed. */
static inline int64_t hits_plain(int dim, const sct_scan *scan, const double *x, double square,
                                 int32_t self, int32_t *hit) {
  int64_t m = 0;
  for (int64_t j = 0; j < scan->n; j++) {
    hit[m] = scan->point[j];
    m += (square_of(dim, scan, x, j) < square) & (scan->point[j] != self);
  }
  return m;
}

static inline double lesser(double a, double b) {
  return a < b ? a : b; /* fmin cares for NaN, and is a call */
}

static inline double least(const double *four) {
  return lesser(lesser(four[0], four[1]), lesser(four[2], four[3]));
}

static inline double closest_plain(int dim, const sct_scan *scan, const double *x, int32_t self) {
  double best[4] = {INFINITY, INFINITY, INFINITY, INFINITY};
  for (int64_t j = 0; j < scan->n; j += 4) {
    for (int l = 0; l < 4; l++) {
      double square = square_of(dim, scan, x, j + l);
      bool counts = (square < best[l]) & (scan->point[j + l] != self);
      best[l] = counts ? square : best[l];
    }
  }
  return least(best);
}

/* -- x86-64 with AVX2 -------------------------------------------------------------------------- */

#if WIDE
/* The same four points at a time, with AVX2: the same operations in the same order, and no fused
 * multiply-add, so the same bits. */
#define AVX2 __attribute__((target("avx2"), always_inline)) static inline

AVX2 __m256d squares_of(int dim, const sct_scan *scan, const __m256d *x, int64_t j) {
  __m256d sum = _mm256_setzero_pd();
  for (int k = 0; k < dim; k++) {
    __m256d d = _mm256_sub_pd(_mm256_loadu_pd(scan->x[k] + j), x[k]);
    __m256d square = _mm256_mul_pd(d, d);
    sum = k == 0 ? square : _mm256_add_pd(sum, square);
  }
  return sum;
}

/* Bytes that move those 32-bit lanes to the front whose bit is set in the row's number. */
#define LANE(l) 4 * (l), 4 * (l) + 1, 4 * (l) + 2, 4 * (l) + 3
static const _Alignas(16) uint8_t to_front[16][16] = {
    {0},
    {LANE(0)},
    {LANE(1)},
    {LANE(0), LANE(1)},
    {LANE(2)},
    {LANE(0), LANE(2)},
    {LANE(1), LANE(2)},
    {LANE(0), LANE(1), LANE(2)},
    {LANE(3)},
    {LANE(0), LANE(3)},
    {LANE(1), LANE(3)},
    {LANE(0), LANE(1), LANE(3)},
    {LANE(2), LANE(3)},
    {LANE(0), LANE(2), LANE(3)},
    {LANE(1), LANE(2), LANE(3)},
    {LANE(0), LANE(1), LANE(2), LANE(3)},
};

AVX2 int64_t hits_wide(int dim, const sct_scan *scan, const double *at, double square, int32_t self,
                       int32_t *hit) {
  __m256d x[SCT_DIM_MAX], limit = _mm256_set1_pd(square);
  __m128i me = _mm_set1_epi32(self);
  for (int k = 0; k < dim; k++) x[k] = _mm256_set1_pd(at[k]);
  int64_t m = 0;
  for (int64_t j = 0; j < scan->n; j += 4) {
    __m128i point = _mm_loadu_si128((const __m128i *)(scan->point + j));
    __m256d near = _mm256_cmp_pd(squares_of(dim, scan, x, j), limit, _CMP_LT_OQ);
    int is_me = _mm_movemask_ps(_mm_castsi128_ps(_mm_cmpeq_epi32(point, me)));
    int set = _mm256_movemask_pd(near) & ~is_me;
    __m128i order = _mm_load_si128((const __m128i *)to_front[set]);
    _mm_storeu_si128((__m128i *)(hit + m), _mm_shuffle_epi8(point, order));
    m += __builtin_popcount((unsigned)set);
  }
  return m;
}

AVX2 double closest_wide(int dim, const sct_scan *scan, const double *at, int32_t self) {
  const __m256d none = _mm256_set1_pd(INFINITY);
  __m256d x[SCT_DIM_MAX], best = none;
  __m128i me = _mm_set1_epi32(self);
  for (int k = 0; k < dim; k++) x[k] = _mm256_set1_pd(at[k]);
  for (int64_t j = 0; j < scan->n; j += 4) {
    __m128i point = _mm_loadu_si128((const __m128i *)(scan->point + j));
    __m256i is_me = _mm256_cvtepi32_epi64(_mm_cmpeq_epi32(point, me));
    __m256d square = squares_of(dim, scan, x, j);
    square = _mm256_blendv_pd(square, none, _mm256_castsi256_pd(is_me));
    best = _mm256_min_pd(square, best); /* best where the square is NaN */
  }
  double b[4];
  _mm256_storeu_pd(b, best);
  return least(b);
}

__attribute__((target("avx2"))) static int64_t hits_best(const sct_scan *scan, const double *x,
                                                         double square, int32_t self,
                                                         int32_t *hit) {
  return BY_DIM(scan->dim, hits_wide, scan, x, square, self, hit);
}

__attribute__((target("avx2"))) static double closest_best(const sct_scan *scan, const double *x,
                                                           int32_t self) {
  return BY_DIM(scan->dim, closest_wide, scan, x, self);
}

static bool is_wide(void) {
  return __builtin_cpu_supports("avx2");
}
#else
static bool is_wide(void) {
  return false;
}

static int64_t hits_best(const sct_scan *scan, const double *x, double square, int32_t self,
                         int32_t *hit) {
  return BY_DIM(scan->dim, hits_plain, scan, x, square, self, hit);
}

static double closest_best(const sct_scan *scan, const double *x, int32_t self) {
  return BY_DIM(scan->dim, closest_plain, scan, x, self);
}
#endif

/* -- choice ------------------------------------------------------------------------------------ */

void sct_scan_init(sct_scan *scan, int dim) {
  scan->dim = dim;
  scan->wide = is_wide();
  scan->n = 0;
}

int64_t sct_scan_hits(const sct_scan *scan, const double *x, double square, int32_t self,
                      int32_t *hit) {
  if (scan->wide) return hits_best(scan, x, square, self, hit);
  return BY_DIM(scan->dim, hits_plain, scan, x, square, self, hit);
}

double sct_scan_closest(const sct_scan *scan, const double *x, int32_t self) {
  if (scan->wide) return closest_best(scan, x, self);
  return BY_DIM(scan->dim, closest_plain, scan, x, self);
}
