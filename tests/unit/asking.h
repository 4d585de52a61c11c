/* asking.h - requests answered within the test: what goes in and what comes out. */
#ifndef ASKING_H
#define ASKING_H

#include "answer.h"
#include "doc.h"

/* Limits that only the tests of limits change. */
limits asking_limits(void);

/* A reply, decoded; free with asked_clear. */
typedef struct {
  reply raw;
  const doc *root; /* of the body */
  doc_arena *arena;
} asked;

/* JSON in, JSON out. */
asked ask_json(const char *process, const char *body);

/* Anything: body as `question` says, the reply decoded by its type and coding. */
asked ask_all(const ask *question);
void asked_clear(asked *a);

/* The same request in CBOR; malloc'ed. */
void *cbor_of(const char *json, size_t *size);

/* Value at a JSON pointer, through number arrays only to the array itself. */
const doc *at_pointer(const doc *root, const char *pointer);

/* Number there; fails the test if there is none. */
double number_at(const doc *root, const char *pointer);

/* Array of numbers there, `count` of them in all; fails the test if it is not. */
const double *numbers_at(const doc *root, const char *pointer, int64_t count);

/* The pointers of a problem's errors, in their order with a space between. */
const char *culprits_of(const asked *a, char *room, size_t size);

#endif
