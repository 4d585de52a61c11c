/* study_row.h - a row of the table of a study: what the case takes from the results of its runs,
 * and what the paper printed. Proof: http.study
 */
#ifndef SCATTERD_STUDY_ROW_H
#define SCATTERD_STUDY_ROW_H

#include "study_run.h"

typedef struct {
  int64_t cells;
  const char *varied; /* parameter that varies from row to row, and its value here */
  double value;
  int64_t points; /* of the cloud */
  int64_t runs;   /* so far */
  doc *members;   /* object: means over them */
  double seconds; /* of a run, mean */
  doc *paper;     /* object: what the paper printed, by member; empty if nothing */
  /* request of the first cloud; owned */
  const doc *request;
  doc_arena *request_arena;
} study_row;

/* Makes what a run found part of the row's means; the first run makes the row. False when out of
 * memory. */
bool study_row_add(task *t, study_run *r, const doc *result, study_row *row);

/* `before`: the row before, NULL if there is none; rates compare with it. */
void study_row_write(emit *e, const study_row *row, const study_row *before);

#endif
