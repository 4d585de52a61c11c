/* body.h - the body of an ask, from bytes to a document. Proof: unit.answer */
#ifndef SCATTERD_BODY_H
#define SCATTERD_BODY_H

#include "answer.h"
#include "task.h"

/* Undoes the content coding, within limits; *plain is to be freed, NULL where the body is plain
 * already. False with the problem in the reply. */
bool body_unpack(const ask *a, void **plain, size_t *size, reply *r);

/* Decodes a plain body by its media type into the task's arena. NULL with the problem in the reply.
 */
const doc *body_decode(const ask *a, const void *body, size_t size, task *t, reply *r);

#endif
