/* param_inner.h - the table of parameters, for what reads and prints them. */
#ifndef SCATTERD_PARAM_INNER_H
#define SCATTERD_PARAM_INNER_H

#include <stddef.h>

#include "param.h"

typedef enum { TEXT, URL, STORE, COUNT, BYTES, SECONDS, LEVEL, CHOICE } kind;

typedef struct {
  const char *name;
  kind kind;
  const char *unit; /* as --help shows it; of a CHOICE: what there is, with | between */
  size_t offset;
  const char *initial; /* as a configuration file would hold it */
  double least, most;
  const char *help;
} parameter;

#define PARAM_NO_END 9e15 /* below 2^53: every integer up to here is exact in a double */

extern const parameter param_table[];
extern const int param_rows;

#endif
