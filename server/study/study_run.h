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

/* Makes and reads the request for cloud number `cloud` of a row, with what study_run_measure found.
 * What is wrong with it becomes complaints of t, at the inputs of the study that are to blame.
 * Close the run in any case. */
bool study_run_open(task *t, const study_input *in, int64_t row, int64_t cloud, double measured,
                    study_run *r);

/* Where a case has a number to be measured `before` a run (the stable step of ps on its cloud),
 * another run with the operator and parameters said there finds it. 1 where there is none. False
 * with complaints, t->error or t->blame. */
bool study_run_measure(task *t, const study_input *in, int64_t row, int64_t cloud, double fraction,
                       double *measured);

/* Runs it: the decoded result document, valid until the run is closed. NULL with t->error and
 * t->blame. `fraction` of the study is done before. */
const doc *study_run_perform(task *t, study_run *r, double fraction);

void study_run_close(study_run *r);

/* Value at a pointer into a result document, whose objects stand under "value"; NULL if none. */
const doc *study_run_value(const doc *result, const char *pointer);

#endif
