#include "scatter/kernel.h"

#include <math.h>
#include <string.h>

/* [H11] eq. 19. In double precision: the paper's own constants are single. */
#define CENTER_S 1.41421356237309504880
#define CENTER_Z (512 * CENTER_S - 745)
#define CENTER_A ((480 * CENTER_S - 705) / CENTER_Z)
#define CENTER_C ((1515 - 960 * CENTER_S) / CENTER_Z)
#define CENTER_D (-210 / CENTER_Z)
#define CENTER_E ((480 * CENTER_S - 600) / CENTER_Z)

#define EXPONENTIAL_C2 (0.4 * 0.4)
#define GAUSSIAN_RATE 9.0

static inline double center(double q) {
  return CENTER_A + q * q * (CENTER_C + q * (CENTER_D + q * CENTER_E));
}
static inline double center_slope(double q) {
  return q * (2 * CENTER_C + q * (3 * CENTER_D + q * 4 * CENTER_E));
}

static inline double rational(double q) {
  return 1 / q - 1;
}
static inline double rational_slope(double q) {
  return -1 / (q * q);
}

static inline double bell(double q) {
  return q < 0.5 ? 2 - 4 * q * q : 4 * (1 - q) * (1 - q);
}
static inline double bell_slope(double q) {
  return q < 0.5 ? -8 * q : -8 * (1 - q);
}

static inline double spiky(double q) {
  return (1 - q) * (1 - q) * (1 - q);
}
static inline double spiky_slope(double q) {
  return -3 * (1 - q) * (1 - q);
}

static inline double cubic(double q) {
  return q < 0.5 ? 2.0 / 3 - 4 * q * q * (1 - q) : 4.0 / 3 * (1 - q) * (1 - q) * (1 - q);
}
static inline double cubic_slope(double q) {
  return q < 0.5 ? q * (12 * q - 8) : -4 * (1 - q) * (1 - q);
}

static inline double quartic(double q) {
  return 1 - q * q * (6 - q * (8 - 3 * q));
}
static inline double quartic_slope(double q) {
  return -12 * q * (1 - q) * (1 - q);
}

static inline double exponential(double q) {
  return exp(-q * q / EXPONENTIAL_C2);
}
static inline double exponential_slope(double q) {
  return -2 * q / EXPONENTIAL_C2 * exponential(q);
}

static inline double wendland(double q) {
  const double p = (1 - q) * (1 - q);
  return p * p * (4 * q + 1);
}
static inline double wendland_slope(double q) {
  return -20 * q * (1 - q) * (1 - q) * (1 - q);
}

static inline double gaussian(double q) {
  return exp(-GAUSSIAN_RATE * q * q);
}
static inline double gaussian_slope(double q) {
  return -2 * GAUSSIAN_RATE * q * gaussian(q);
}

/* symbol, name, singular, source. Each symbol has a formula and its slope above. */
#define KERNELS(X)                                               \
  X(center, "center", false, "Huang et al. 2011, eq. 19")        \
  X(rational, "rational", true, "Koshizuka and Oka 1996")        \
  X(bell, "bell", false, "Yoon, Koshizuka and Oka 1999")         \
  X(spiky, "spiky", false, "Shakibaeinia and Jin 2010")          \
  X(cubic, "cubic-spline", false, "Belytschko et al. 1996")      \
  X(quartic, "quartic-spline", false, "Belytschko et al. 1996")  \
  X(exponential, "exponential", false, "Belytschko et al. 1996") \
  X(wendland, "wendland-c2", false, "Wendland 1995")             \
  X(gaussian, "gaussian", false, "common practice, cut at three lengths")

/* The public faces of a formula: cut at the support, and in bulk so that the call through the
 * table costs once per neighbourhood instead of once per pair. */
#define FACES(symbol, name, singular, source)                                \
  static double symbol##_at(double q) {                                      \
    return q < 1 ? symbol(q) : 0;                                            \
  }                                                                          \
  static double symbol##_slope_at(double q) {                                \
    return q < 1 ? symbol##_slope(q) : 0;                                    \
  }                                                                          \
  static void symbol##_fill(int64_t n, const double *q, double *weight) {    \
    for (int64_t k = 0; k < n; k++) weight[k] = q[k] < 1 ? symbol(q[k]) : 0; \
  }
KERNELS(FACES)
#undef FACES

static const sct_kernel table[] = {
#define ROW(symbol, name, singular, source) \
  {name, symbol##_at, symbol##_slope_at, symbol##_fill, singular, source},
    KERNELS(ROW)
#undef ROW
};

int sct_kernel_count(void) {
  return (int)(sizeof table / sizeof table[0]);
}

const sct_kernel *sct_kernel_at(int k) {
  return k >= 0 && k < sct_kernel_count() ? &table[k] : NULL;
}

const sct_kernel *sct_kernel_find(const char *name) {
  for (int k = 0; name != NULL && k < sct_kernel_count(); k++) {
    if (strcmp(table[k].name, name) == 0) return &table[k];
  }
  return NULL;
}
