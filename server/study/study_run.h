/* study_run.h - one cloud of one row of a study: an ordinary request of another process, made of
 * the case's template, read and run as a posted one, in a task of its own. Proof: http.study
 */
#ifndef SCATTERD_STUDY_RUN_H
#define SCATTERD_STUDY_RUN_H

#include "cloud_input.h"
#include "perform.h"
#include "study_input.h"

typedef struct {
  const study_input *in;
  int64_t row;
  scope names;
  const doc *request;       /* as it could be posted */
  doc_arena *request_arena; /* its owner */
  task own;                 /* with an arena of its own */
  performance work;
  doc_arena *result_arena;
  /* who is told, and what */
  const task *outer;
  double fraction; /* of the study done before */
} study_run;

/* Makes and reads the request for cloud number `cloud` of a row. What is wrong with it becomes
 * complaints of t, at the inputs of the study that are to blame. Close the run in any case. */
bool study_run_open(task *t, const study_input *in, int64_t row, int64_t cloud, study_run *r);

/* Runs it: the decoded result document, valid until the run is closed. NULL with t->error and
 * t->blame. `fraction` of the study is done before. */
const doc *study_run_perform(task *t, study_run *r, double fraction);

void study_run_close(study_run *r);

#endif
