/* doc_make.h - documents made in memory, value by value. Their nodes belong to the task's arena and
 * may be changed by who made them. Every function that makes one returns NULL when out of memory
 * (t->error).
 * Proof: unit.doc_make
 */
#ifndef SCATTERD_DOC_MAKE_H
#define SCATTERD_DOC_MAKE_H

#include "task.h"

/* An object without members. */
doc *doc_make_object(task *t, const char *key);
doc *doc_make_number(task *t, const char *key, double value);
/* [n], the numbers copied. */
doc *doc_make_numbers(task *t, const char *key, const double *value, int64_t n);

/* A copy of the node under another key, that shares children, text and numbers with it. */
doc *doc_make_alias(task *t, const char *key, const doc *d);

/* Adds a member or element behind those there are. False if there is none (NULL). */
bool doc_append(doc *container, doc *child);

/* Appends to an object the members of `from` that it does not have yet. False when out of memory.
 */
bool doc_add_members(task *t, const doc *from, doc *into);

/* Value at a JSON pointer without escapes; an element of an array of numbers cannot be pointed to
 * but by doc_number_at. NULL if there is nothing. */
const doc *doc_at_pointer(const doc *d, const char *pointer);

/* Number there, also within an array of numbers; NaN if there is none. */
double doc_number_at(const doc *d, const char *pointer);

/* A copy of the numbers in `d` that doc_mean can change: a number, an array of numbers, or an
 * object of these; anything else in it is left out (NULL without an error if it is nothing else).
 */
doc *doc_mean_begin(task *t, const doc *d);

/* Makes `mean`, that of the k - 1 documents before, the mean of k by adding `d`, number by number
 * where both have the same shape. The mean of equal numbers is that number. */
void doc_mean(doc *mean, const doc *d, int64_t k);

#endif
