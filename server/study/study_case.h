/* study_case.h - the cases of process `study`: data, one file each in schemas/cases, built into the
 * program. A case is a request of `solve` or `apply` with places to fill in, and what the paper
 * printed about it. schemas/README.md describes the form.
 * Proof: http.study (every case runs), unit.schemas (form)
 */
#ifndef SCATTERD_STUDY_CASE_H
#define SCATTERD_STUDY_CASE_H

#include "doc.h"

enum { STUDY_CASES_MAX = 64 };

/* Names of all cases, NULL at the end. */
void study_case_names(const char *names[STUDY_CASES_MAX + 1]);

/* Number k of those names, decoded. *arena owns it and is set in either case; NULL when out of
 * memory. */
const doc *study_case_open(int k, doc_arena **arena);

#endif
