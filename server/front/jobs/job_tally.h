/* job_tally.h - how many jobs each submitter has that are not over. Test: unit.job_tally.
 */
#ifndef SCATTERD_JOB_TALLY_H
#define SCATTERD_JOB_TALLY_H

#include <stdbool.h>
#include <stdint.h>

typedef struct tally_row tally_row;
typedef struct {
  tally_row *first; /* only of those who have any */
} job_tally;

/* Counts one more (`by` 1) or one less (-1). False when out of memory. Cost: the number of
 * submitters that have any. */
bool job_tally_add(job_tally *t, const char *submitter, int by);

int64_t job_tally_of(const job_tally *t, const char *submitter);
void job_tally_clear(job_tally *t);

#endif
