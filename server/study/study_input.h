/* study_input.h - the inputs of process `study`: a case, and what differs from its defaults.
 * Proof: http.study
 */
#ifndef SCATTERD_STUDY_INPUT_H
#define SCATTERD_STUDY_INPUT_H

#include "operator_input.h"
#include "scope.h"
#include "study_case.h"

typedef struct {
  doc_arena *arena; /* of the case */
  const char *name;
  const doc *root; /* the case; NULL: none could be read */
  numbers cells;   /* [rows] of the meshes */
  /* Parameters of the case: numbers, and arrays of them. A parameter that is a number but was
   * given as an array varies: the study goes over its values, with all meshes for each. */
  doc *parameters;
  const doc *varied; /* the member of `parameters`, or NULL */
  doc *operator_doc; /* of all runs, as it is posted */
  sct_operator op;   /* the same, with the defaults of its scheme */
  int64_t rows;      /* of the table; row k has the mesh number k % cells.rows */
  int64_t seeds;     /* clouds per row */
} study_input;

extern const char *const study_inputs[]; /* names, NULL at the end */

/* Reads all inputs into the zeroed *s; what is wrong becomes complaints. False if there is no study
 * to go on with. */
bool study_input_read(task *t, const item *in, study_input *s);
void study_input_clear(study_input *s);

/* Names and values for cloud number `cloud` of row k; close the scope in any case. False when out
 * of memory. */
bool study_input_scope(task *t, const study_input *s, int64_t k, int64_t cloud, scope *names);

/* The operator that `own`, members over those of the case (or NULL), makes. */
bool study_input_operator(task *t, const study_input *s, const doc *own, sct_operator *op);

#endif
