#include "job_tally.h"

#include <stdlib.h>
#include <string.h>

struct tally_row {
  tally_row *next;
  int64_t count;
  char submitter[];
};

/* Where the row of a submitter hangs, or would. */
static tally_row **place_of(tally_row **at, const char *submitter) {
  while (*at != NULL && strcmp((*at)->submitter, submitter) != 0) at = &(*at)->next;
  return at;
}

static tally_row *row_new(const char *submitter) {
  const size_t size = strlen(submitter) + 1;
  tally_row *row = calloc(1, sizeof *row + size);
  if (row != NULL) memcpy(row->submitter, submitter, size);
  return row;
}

bool job_tally_add(job_tally *t, const char *submitter, int by) {
  tally_row **at = place_of(&t->first, submitter), *row = *at;
  if (row == NULL) {
    if (by < 0) return true;
    row = *at = row_new(submitter);
    if (row == NULL) return false;
  }
  row->count += by;
  if (row->count > 0) return true;
  *at = row->next;
  free(row);
  return true;
}

int64_t job_tally_of(const job_tally *t, const char *submitter) {
  tally_row *first = t->first;
  const tally_row *row = *place_of(&first, submitter);
  return row != NULL ? row->count : 0;
}

void job_tally_clear(job_tally *t) {
  while (t->first != NULL) {
    tally_row *row = t->first;
    t->first = row->next;
    free(row);
  }
}
