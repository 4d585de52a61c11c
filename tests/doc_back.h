/* doc_back.h - what must hold for every document a decoder has taken. */
#ifndef TESTS_DOC_BACK_H
#define TESTS_DOC_BACK_H

#include "doc.h"
#include "emit.h"

/* Writes the document and decodes that again: it must be the same (where JSON has a null for a
 * number that is not finite, it must only be taken). NULL if so, else what is wrong: the caller
 * frees it. */
char *doc_back(const doc *d, emit_format format);

#endif
