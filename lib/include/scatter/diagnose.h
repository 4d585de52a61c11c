/* diagnose.h - what a cloud does to the operators on it, and how far a field is from another. */
#ifndef SCATTER_DIAGNOSE_H
#define SCATTER_DIAGNOSE_H

#include "scatter/stencil.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Point by point; every member may be NULL. They depend on points, kernel and support only.
 * Points without neighbours get zeros; with a singular M a zero tensor. */
typedef struct {
  int32_t *neighbours;           /* [n] */
  double *number_density;        /* [n] S_w */
  double *artificial_velocity;   /* [n][dim] u_N = 2 d o / S_w, [H16] eq. 13 (1 / length) */
  double *effective_diffusivity; /* [n][dim(dim+1)/2] tensor of ips, [H16] eq. 22, as xx, yy, zz,
                                    xy, xz, yz; lap phi becomes tau_ab phi_ab (no unit) */
  double *condition;             /* [n] 1-norm condition number of M; infinity if singular */
} sct_diagnosis;

/* Computes what is not NULL. Proof: verify.diagnose (ps Laplacian of a coordinate = u_N, ips
 * Laplacian of a quadratic = tau : Hessian) */
SCT_NODISCARD sct_status sct_diagnose(const sct_stencil *stencil, const sct_work *work,
                                      const sct_diagnosis *diagnosis, sct_error *err);

/* min, mean, max of value over the points with mask != 0 (NULL: all); NaN if there are none. */
typedef struct {
  double min, mean, max, rms;
  int64_t points;
} sct_range;
sct_range sct_range_of(const double *value, int64_t n, int64_t stride, const uint8_t *mask);

/* Norms of e = value - exact over the points with mask != 0 (NULL: all): l1 = mean |e|,
 * l2 = root mean square, linf = max |e|, l2_relative = l2 / rms(exact) (NaN where that is 0),
 * linf_all = max |e| over all points. value, exact [n][components]; |e| is the Euclidean length.
 * Proof: unit.diagnose */
typedef struct {
  double l1, l2, linf, l2_relative, linf_all;
  int64_t points;
} sct_norms;
sct_norms sct_norms_of(const double *value, const double *exact, int64_t n, int components,
                       const uint8_t *mask);

#ifdef __cplusplus
}
#endif
#endif
