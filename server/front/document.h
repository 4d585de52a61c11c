/* document.h - the documents built into the program: made from schemas/ by embed.py.
 */
#ifndef SCATTERD_DOCUMENT_H
#define SCATTERD_DOCUMENT_H

#include <stddef.h>

typedef struct {
  const char *name; /* "processes/solve.json" */
  const char *bytes;
  size_t size;
} document;

extern const document documents[];
extern const size_t document_count;

#endif
