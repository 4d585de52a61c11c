/* stencil.h - gradient and Laplacian at a point as weights of its neighbours.
 *
 * Every operator of this library is linear and annihilates constants:
 *   (grad phi)_i = sum_j g_ij (phi_j - phi_i),    (lap phi)_i = sum_j l_ij (phi_j - phi_i).
 * A row holds g_ij [dim] and l_ij for the neighbours j of one point i. Notation as in
 * lib/README.md: r_j = x_j - x_i, r = |r_j|, w = w(r / r_e), S_w = sum w,
 *   o = sum w r_j / r^2,   M = sum w r_j r_j^T / r^2,   T_ab = (1/2) sum l_ij r_a r_b.
 */
#ifndef SCATTER_STENCIL_H
#define SCATTER_STENCIL_H

#include "scatter/kernel.h"
#include "scatter/search.h"

#ifdef __cplusplus
extern "C" {
#endif

/* symbol, name. Exact for: mps, ps lattices; ips linear functions; lsmps polynomials of its degree.
 *   mps    g = (d/S_w) w r_j / r^2    l = 2 d w / (lambda S_w), lambda = sum w r^2 / sum w
 *                                                                           [H11] eq. 5, 7
 *   ps     g = (d/S_w) w r_j / r^2    l = (2 d/S_w) w / r^2                 [H16] eq. 1, 2
 *   ips    g = M^-1 w r_j / r^2       l = (2 d/S_w) (w / r^2) (1 - o . M^-1 r_j)
 *                                                                           [H16] eq. 15-20, 26-27
 *   ipsn   as ips with l d / trace T, where trace T / d > 0.3; else an lsmps row
 *   lsmps  weighted least squares fit of the complete Taylor polynomial of `degree`
 */
#define SCT_SCHEME_LIST(X) \
  X(SCT_MPS, "mps")        \
  X(SCT_PS, "ps")          \
  X(SCT_IPS, "ips")        \
  X(SCT_IPSN, "ipsn")      \
  X(SCT_LSMPS, "lsmps")

/* Kernel of the gradient in u . grad phi, with c = u . r_j / (|u| r), gamma = |u| h / (2 mu),
 * beta(gamma) = coth gamma - 1 / gamma:
 *   none       w
 *   exact      w - beta w(h) (w'(r) / w'(h)) c                       [H11] eq. 23-28
 *   cosine     w (1 - beta c)
 *   published  w - (16/5) (h/L) (|u|/U) beta(s gamma) c |c| / |w'(1/2)|, what [H11] ran; scheme
 *              mps, kernel center, radius 2 only. Dimensionally inconsistent: for reproduction.
 *   limited    w, in a linear fit whose constant is free, for every scheme: sum_j g_ij = 0. Only
 *              its upwind half goes into a matrix, limited.h adds the rest; not for lsmps above
 *              degree 2.
 * mps and ps use W in the sum, S_w stays that of w; the matrix schemes use it in M and b of a
 * gradient of first degree. With `limited` normal derivatives are linear for lsmps too: their
 * weights have the right sign, or nearly so. */
#define SCT_UPWIND_LIST(X)             \
  X(SCT_UPWIND_NONE, "none")           \
  X(SCT_UPWIND_EXACT, "exact")         \
  X(SCT_UPWIND_COSINE, "cosine")       \
  X(SCT_UPWIND_PUBLISHED, "published") \
  X(SCT_UPWIND_LIMITED, "limited")

/* S_w and lambda of the point itself, or of a complete lattice neighbourhood of spacing h. Where a
 * support had to be widened they are the point's own: the lattice's are those of another radius. */
#define SCT_DENSITY_LIST(X)     \
  X(SCT_DENSITY_LOCAL, "local") \
  X(SCT_DENSITY_REFERENCE, "reference")

/* Weight of the lsmps fit. */
#define SCT_WEIGHT_LIST(X)             \
  X(SCT_WEIGHT_KERNEL_R2, "kernel/r2") \
  X(SCT_WEIGHT_KERNEL, "kernel")

#define SCT_NAME_ENUM(symbol, name) symbol,
typedef enum { SCT_SCHEME_LIST(SCT_NAME_ENUM) SCT_SCHEME_COUNT } sct_scheme;
typedef enum { SCT_UPWIND_LIST(SCT_NAME_ENUM) SCT_UPWIND_COUNT } sct_upwind;
typedef enum { SCT_DENSITY_LIST(SCT_NAME_ENUM) SCT_DENSITY_COUNT } sct_density;
typedef enum { SCT_WEIGHT_LIST(SCT_NAME_ENUM) SCT_WEIGHT_COUNT } sct_weight;
#undef SCT_NAME_ENUM

/* Name of a value, NULL out of range; find returns the COUNT if there is none of that name. */
const char *sct_scheme_name(sct_scheme value);
sct_scheme sct_scheme_find(const char *name);
const char *sct_upwind_name(sct_upwind value);
sct_upwind sct_upwind_find(const char *name);
const char *sct_density_name(sct_density value);
sct_density sct_density_find(const char *name);
const char *sct_weight_name(sct_weight value);
sct_weight sct_weight_find(const char *name);

typedef struct {
  sct_scheme scheme;
  int degree;        /* lsmps: 2, 3 or 4 */
  sct_weight weight; /* lsmps */
  const sct_kernel *kernel;
  double radius;       /* support radius r_e in spacings */
  sct_density density; /* mps, ps, ips */
  sct_upwind upwind;
  double gamma_scale;      /* s of `published` */
  double reference_length; /* L of `published` (length) */
  double reference_speed;  /* U of `published` (length / time) */
} sct_operator;

/* Defaults of a scheme: kernel center for mps and rational else; radius 2.0 (beyond it a lattice
 * row next to the boundary is lopsided), 2.1 for lsmps degree 2, 2.5 for degree 3, 3.1 for degree
 * 4; density reference for mps, local else; upwind none; weight kernel/r2; gamma_scale, L, U = 1.
 */
sct_operator sct_operator_default(sct_scheme scheme, int degree);

/* SCT_E_ARGUMENT for a radius outside [1, 8], a degree outside [2, 4], a `published` without what
 * it needs, a kernel that `exact` cannot use (w'(h) = 0) or a non-positive scale. */
SCT_NODISCARD sct_status sct_operator_check(const sct_operator *op, sct_error *err);

typedef struct sct_stencil sct_stencil; /* opaque: cloud, lists, operator and their constants */

/* Prepares the rows of `op` on a cloud of spacing h: finds the neighbours within op->radius * h.
 * A distance within 1e-10 of the support counts as outside, so that a lattice point at 2 h is not
 * in or out by rounding. Lists are ascending: a row is the same to the last bit whatever search
 * found its neighbours, and in any part of the cloud that has them all. Borrows the cloud and the
 * search. *stencil is NULL on failure. SCT_E_ARGUMENT, SCT_E_LIMIT (more than `limit` neighbours),
 * SCT_E_MEMORY. Proof: unit.stencil */
SCT_NODISCARD sct_status sct_stencil_build(const sct_cloud *cloud, const sct_search *search,
                                           double spacing, const sct_operator *op, int64_t limit,
                                           const sct_work *work, sct_stencil **stencil,
                                           sct_error *err);
void sct_stencil_free(sct_stencil **stencil);
const sct_lists *sct_stencil_lists(const sct_stencil *stencil);
const sct_cloud *sct_stencil_cloud(const sct_stencil *stencil);
const sct_operator *sct_stencil_operator(const sct_stencil *stencil);
double sct_stencil_spacing(const sct_stencil *stencil);

/* From now on sct_stencil_row notes in reach [n] (length), zeroes before, the widest support that
 * it looked at for the row of a point: the row depends on nothing farther away. NULL: no more.
 * Proof: verify.partition */
void sct_stencil_note_reach(sct_stencil *stencil, double *reach);

/* What to compute of a row. SCT_ROW_SOLVE says that the Laplacian is to be solved with, which is
 * asked more of than one to be evaluated; a normal derivative always is. */
enum {
  SCT_ROW_GRADIENT = 1,
  SCT_ROW_LAPLACIAN = 2,
  SCT_ROW_SOLVE = 4,
  SCT_ROW_NORMAL = 8,
  SCT_ROW_LINEAR = 16 /* with SCT_ROW_GRADIENT: mps and ps take the gradient of ips */
};

typedef struct {
  int want;               /* SCT_ROW_*, SCT_ROW_NORMAL not with SCT_ROW_LAPLACIAN */
  const double *velocity; /* [dim] u of an upwinded gradient; NULL: central */
  double diffusivity;     /* mu of an upwinded gradient */
  const double *normal;   /* [dim] outward unit normal of SCT_ROW_NORMAL */
} sct_row_request;

/* What became of a row. */
enum {
  SCT_ROW_WIDENED = 1,  /* a support wider than asked for */
  SCT_ROW_FALLBACK = 2, /* not the scheme or degree asked for */
  SCT_ROW_LOOSE = 4     /* an lsmps row to solve with that is less stable than asked for */
};

/* One row. Memory belongs to the room it was made in, until the next row. */
typedef struct {
  int64_t n;            /* neighbours */
  const int32_t *index; /* [n] */
  double *gradient;     /* [dim][n] g_ij by component, if asked for (1 / length) */
  double *laplacian;    /* [n] l_ij, if asked for (1 / length^2) */
  double *normal;       /* [n] normal . g_ij, if asked for (1 / length); in laplacian's memory */
  double support;       /* r_e used (length) */
  int flags;
} sct_row;

/* Scratch memory for rows, one per thread. */
typedef struct sct_room sct_room;
SCT_NODISCARD sct_status sct_room_new(const sct_stencil *stencil, sct_room **room, sct_error *err);
void sct_room_free(sct_room **room);

/* The row of point i. A normal derivative is that of the linear gradient (eq. 19 of [H16]) for
 * every scheme but lsmps.
 *
 * A neighbourhood is accepted if it has at least dim neighbours (dim + 1 for a Laplacian) that
 * span the space (M's smallest pivot above 1e-4 of its trace), and for an lsmps fit at least one
 * more than unknowns with the fit's condition number at most 12 (degree 3: 50, 4: 300; ten times
 * that for what is solved with). To be solved with, sum |l| / sum l has to be at most 1.5, and
 * sum |c| / |sum c| of a normal derivative c at most 3 in 2-D (degree 3: 4.6, 4: 7.3; three tenths
 * less in 1-D and more in 3-D) with a negative sum. If not, the support is widened
 * to 2.0, 2.5, 3.1, 3.6, 4.1, 5.1, 6.5, 8.2, 11, 16, 23, 32 h (those beyond its own, up to the
 * limit of neighbours); then a fit is tried with weight w on the same supports, and of all the fits
 * so far the one with the least such quotient is taken if that is at most 15: it is still exact for
 * its degree. If there is none, a fit of degree 2 and last an ips row stand in for lsmps; else
 * SCT_E_DEFICIENT. Proof: verify.stencil (exactness), verify.order (orders, also one-sided and at
 * voids), verify.monotone (signs), unit.stencil (degenerate neighbourhoods) */
SCT_NODISCARD sct_status sct_stencil_row(const sct_stencil *stencil, int64_t i,
                                         const sct_row_request *request, sct_room *room,
                                         sct_row *row, sct_error *err);

/* Applies the operators to a field: smoothed [n] = sum w phi_j / sum w ([H11] eq. 2), gradient
 * [n][dim], laplacian [n]; each may be NULL. SCT_E_DEFICIENT lists the points that have no row.
 * Cost O(entries). Proof: verify.stencil */
SCT_NODISCARD sct_status sct_stencil_apply(const sct_stencil *stencil, const double *field,
                                           const sct_work *work, double *smoothed, double *gradient,
                                           double *laplacian, sct_error *err);

/* The same, and what became of each row: flags [n] of SCT_ROW_*, 0 everywhere if neither gradient
 * nor Laplacian is asked for. Proof: unit.stencil */
SCT_NODISCARD sct_status sct_stencil_apply_flagged(const sct_stencil *stencil, const double *field,
                                                   const sct_work *work, double *smoothed,
                                                   double *gradient, double *laplacian,
                                                   uint8_t *flags, sct_error *err);

/* beta(gamma) = coth gamma - 1/gamma, by its series for small gamma, 1 for infinity.
 * Proof: unit.stencil */
double sct_upwind_beta(double gamma);

#ifdef __cplusplus
}
#endif
#endif
