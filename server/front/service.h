/* service.h - what the handlers of a request work with.
 */
#ifndef SCATTERD_SERVICE_H
#define SCATTERD_SERVICE_H

#include "param.h"
#include "pool.h"

typedef struct {
  const parameters *set;
  pool *pool;
} service;

#endif
