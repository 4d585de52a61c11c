/* fault.h - why something could not be done, in words for the operator. */
#ifndef SCATTERD_FAULT_H
#define SCATTERD_FAULT_H

#include <stdbool.h>

typedef struct {
  char text[512];
} fault;

/* Fills *f and returns false, so that a failure is one line: return fault_set(f, "...", ...). */
bool fault_set(fault *f, const char *format, ...) __attribute__((format(printf, 2, 3)));

#endif
