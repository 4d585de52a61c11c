/* teller.h - progress of an answer as news: what is worth telling, and when. For whoever answers: a
 * worker tells its front (worker.c), a rank writes a file (rank.c). Tests: unit.teller, http.jobs,
 * http.executor_mpi.
 */
#ifndef SCATTERD_TELLER_H
#define SCATTERD_TELLER_H

#include <stdbool.h>

#include "ipc.h"

typedef struct {
  double pause;    /* (s) between news within a phase; the reports in between cost nothing */
  double last;     /* time of the last news, or of the beginning */
  double residual; /* heard of since then, 0 if none was */
  char phase[sizeof((ipc_news *)NULL)->phase];
} teller;

/* The clock that news are stamped with (s), which is also the front's. */
double teller_now(void);

/* Is a report worth telling? Always where a phase begins. Then it is in *news. */
bool teller_takes(teller *t, const char *phase, double fraction, ipc_news *news);

#endif
