/* doc_show.h - a document as one line of text, so that tests can compare it whole.
 *
 * null true 1.5 "text" [1st, 2nd] {"key": value}, arrays of numbers as <2x3: 1 2 3 4 5 6>.
 */
#ifndef SCATTERD_TEST_DOC_SHOW_H
#define SCATTERD_TEST_DOC_SHOW_H

#include <stdio.h>

#include "doc.h"

/* The caller frees the text. NUL characters are shown as \0. */
char *doc_show(const doc *d);

#endif
