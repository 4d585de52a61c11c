/* service.h - what the handlers of a request work with.
 */
#ifndef SCATTERD_SERVICE_H
#define SCATTERD_SERVICE_H

#include "job.h"
#include "param.h"
#include "pool.h"
#include "wait.h"

typedef struct {
  const parameters *set;
  pool *pool;
  store *store;
  jobs *jobs;
  waits *waits;
} service;

#endif
