/* study_paper.h - what the paper printed, where a study runs just what it ran.
 * Proof: http.study
 */
#ifndef SCATTERD_STUDY_PAPER_H
#define SCATTERD_STUDY_PAPER_H

#include "study_row.h"

/* Makes row->paper of the case's columns that belong to operator and parameters of row k, and marks
 * those in `used` [columns]. False when out of memory. */
bool study_paper_find(task *t, const study_input *in, int64_t k, study_row *row, bool *used);

/* Columns of the case (count). */
int64_t study_paper_columns(const study_input *in);

/* The output `reference`: what the case is, where it comes from, what is to be said about it, and
 * the columns used. */
void study_paper_write(emit *e, const study_input *in, const bool *used);

#endif
