/* data_inner.h - what data.c and data_add.c share: the objects under /data.
 */
#ifndef SCATTERD_DATA_INNER_H
#define SCATTERD_DATA_INNER_H

#include "data.h"

struct data_store {
  const parameters *set;
  store *store;
  clerk *clerk;
  data_filing *first; /* of those on their way */
  double expiry;      /* when to look for old ones, by unix_now */
};

#endif
