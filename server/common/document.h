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

extern const document documents[]; /* what the front serves */
extern const size_t document_count;

extern const document study_documents[]; /* cases of process study, by case */
extern const size_t study_document_count;

extern const document um_bridge_documents[]; /* [1] the config of a UM-Bridge model without one */
extern const size_t um_bridge_document_count;

#endif
