/* study_compare.h - a run against reference curves of its case: root mean square differences.
 *
 * A case may have `references`, a list of {"parameters": {..}, "numbers": {name: number},
 * "curves": {name: [{"places": pointer, "values": pointer, "at": [..], "known": [..]}, ..]}}: for
 * runs with those parameters the row has the numbers as its member `reference`, and under each name
 * the root mean square over the places `at`, of all curves together, of the values that the result
 * has at the pointers less those known. Between its places the result is a cubic.
 * Proof: http.study
 */
#ifndef SCATTERD_STUDY_COMPARE_H
#define SCATTERD_STUDY_COMPARE_H

#include "study_run.h"

/* Appends those members. False when out of memory (r->own.error). */
bool study_compare(study_run *r, const doc *result, doc *members);

#endif
