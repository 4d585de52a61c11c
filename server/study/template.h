/* template.h - a request with places to fill in.
 *
 * In the `request` of a study case {"=": "EXPRESSION"} stands for a number of the scope,
 * {"=": "NAME"} for a parameter that is an array (with "most": EXPRESSION, for those of its numbers
 * up to that) or for the text of a field of the case, and {"=": "FIRST", "to": "LAST"} for the
 * integers between. Everything else stands for itself.
 * Proof: http.study
 */
#ifndef SCATTERD_TEMPLATE_H
#define SCATTERD_TEMPLATE_H

#include "emit.h"
#include "read.h"
#include "scope.h"

/* Writes the template filled in. A number that has no value is written as NaN, for the reader of
 * the request to find. */
void template_write(emit *e, const doc *template, scope *s);

/* Where in the request for a study (a pointer) the fault lies that is at `pointer` in the request
 * made of `template`. `mesh`: number of the mesh among the cells. */
void template_blame(const doc *root, const doc *template, const char *pointer, int64_t mesh,
                    char blamed[PROBLEM_POINTER]);

#endif
