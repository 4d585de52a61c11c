/* clouds.h - clouds to test with: pleasant, random, clustered, graded, degenerate. */
#ifndef TESTS_CLOUDS_H
#define TESTS_CLOUDS_H

#include "scatter/cloud.h"

/* Kinds in cloud_names; all lie near the unit box but the outliers. */
enum {
  CLOUD_UNIFORM,   /* random */
  CLOUD_LATTICE,   /* jittered */
  CLOUD_CLUSTERED, /* dense balls on a thin background */
  CLOUD_GRADED,    /* geometrically towards one corner, over nine decades */
  CLOUD_LINE,      /* along a diagonal */
  CLOUD_PLANE,     /* last coordinate 0: a face of the box */
  CLOUD_OUTLIER,   /* random, and one point very far away */
  CLOUD_SPECK,     /* almost coincident: all within 1e-9 */
  CLOUDS
};
extern const char *const cloud_names[CLOUDS];

/* n points of a kind; a `lattice` has the next smaller number. Ends the program if there is no
 * memory. */
sct_cloud cloud_make(int kind, int dim, int64_t n, uint64_t seed);
void cloud_free(sct_cloud *cloud);

/* Random numbers in [0, 1) of a stream. */
double cloud_random(uint64_t *stream);

#endif
