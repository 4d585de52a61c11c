/* search_scan.h - the distance test, over points that lie side by side in memory. */
#ifndef SCATTER_SEARCH_SCAN_H
#define SCATTER_SEARCH_SCAN_H

#include "scatter/cloud.h"

/* Points tested together; how many the test may read and write beyond the last. */
enum { SCT_SCAN_MOST = 2048, SCT_SCAN_PAD = 4 };

typedef struct {
  int dim;
  bool wide; /* use the form of the test that this machine has beyond the common ones */
  int64_t n;
  double x[SCT_DIM_MAX][SCT_SCAN_MOST + SCT_SCAN_PAD];
  int32_t point[SCT_SCAN_MOST + SCT_SCAN_PAD];
} sct_scan;

/* An empty scan, wide where the machine is. */
void sct_scan_init(sct_scan *scan, int dim);

/* Ends a scan that has been filled up to n: what is beyond is never a hit. */
void sct_scan_close(sct_scan *scan);

/* Writes the points j != self with |x_j - x|^2 < square to `hit`, in their order, and returns how
 * many: dx dx + dy dy + dz dz, each operation rounded. All of hit [n + SCT_SCAN_PAD] may be
 * written to. Proof: unit.search.scan */
int64_t sct_scan_hits(const sct_scan *scan, const double *x, double square, int32_t self,
                      int32_t *hit);

/* Smallest |x_j - x|^2 of the points j != self; infinity if there is none. */
double sct_scan_closest(const sct_scan *scan, const double *x, int32_t self);

#endif
