/* service.h - what the handlers of a request work with.
 */
#ifndef SCATTERD_SERVICE_H
#define SCATTERD_SERVICE_H

#include "clerk.h"
#include "executor.h"
#include "job.h"
#include "param.h"
#include "pool.h"
#include "wait.h"

typedef struct service {
  const parameters *set;
  struct gate *gate; /* gate.h */
  clerk *clerk;
  pool *pool;
  executor *executor;
  store *store;
  jobs *jobs;
  waits *waits;
  struct streams *streams;     /* events.h */
  struct outbound *outbound;   /* outbound.h */
  struct callbacks *callbacks; /* callback.h */
  struct data_store *data;     /* data.h */
  struct fetches *fetches;     /* fetch.h */
  struct clock_watch *clock;   /* clock.h */
} service;

#endif
