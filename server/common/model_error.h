/* model_error.h - what went wrong, as UM-Bridge 1.0 tells it: {"error": {"type", "message"}}, which
 * its clients look for whatever the status. Test: unit.model_error.
 */
#ifndef SCATTERD_MODEL_ERROR_H
#define SCATTERD_MODEL_ERROR_H

#include <stddef.h>

/* The type for a status of HTTP. What keeps a request from its model, whatever it asks, has types
 * of its own, which UM-Bridge leaves open: a sampler must not take it for a place where the model
 * fails (InvalidOutput). */
const char *model_error_type(int status);

/* The document: malloc'ed, *size bytes and a NUL after them; NULL when out of memory. Both texts
 * are UTF-8. */
char *model_error_bytes(const char *type, const char *message, size_t *size);

#endif
