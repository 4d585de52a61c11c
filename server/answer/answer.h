/* answer.h - one request, from body to reply: decode, check, solve, encode.
 *
 * This is all a worker does; `scatterd run` calls it without a server. It touches no socket and
 * no file.
 */
#ifndef SCATTERD_ANSWER_H
#define SCATTERD_ANSWER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "limit.h"
#include "media.h"

typedef struct {
  const char *process; /* id: "solve" */
  const void *body;
  size_t size;
  media content; /* of the body: MEDIA_JSON or MEDIA_CBOR */
  coding content_coding;
  media accept; /* wanted for the result: MEDIA_JSON or MEDIA_CBOR */
  coding accept_coding;
  const limits *limits;
  bool (*report)(void *context, const char *phase, double fraction); /* NULL: nobody */
  void *context;
} ask;

typedef struct {
  int status;    /* HTTP status */
  char type[64]; /* media type of the bytes */
  coding coding; /* of the bytes */
  void *bytes;   /* malloc'ed; NULL only when out of memory */
  size_t size;
  int64_t points; /* of the cloud, 0 if there was none; for the log */
} reply;

/* Takes what answers will keep for good; a worker calls it once, before anything else. */
void answer_prepare(void);

/* Answers. Never fails: what goes wrong is a problem document in the reply. The caller frees
 * reply->bytes. */
void answer(const ask *ask, reply *reply);

#endif
