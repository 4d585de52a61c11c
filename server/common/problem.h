/* problem.h - what went wrong, as an RFC 9457 problem document. Knows nothing of HTTP beyond the
 * status number. Used by the worker (bad inputs, unsolvable systems) and by the front (everything
 * else). Test: unit.problem.
 */
#ifndef SCATTERD_PROBLEM_H
#define SCATTERD_PROBLEM_H

#include <stddef.h>

enum { PROBLEM_ERRORS_MAX = 20, PROBLEM_POINTER = 256, PROBLEM_TEXT = 512 };

/* Types with a URI of their own; all others are "about:blank", whose title is the status phrase. */
typedef enum {
  PROBLEM_BLANK,
  PROBLEM_NO_SUCH_PROCESS,
  PROBLEM_NO_SUCH_JOB,
  PROBLEM_RESULT_NOT_READY,
  PROBLEM_TYPES
} problem_type;

typedef struct {
  int status;
  problem_type type;
  char detail[PROBLEM_TEXT];
  int count; /* errors kept, at most PROBLEM_ERRORS_MAX */
  int found; /* errors added in all */
  struct {
    char pointer[PROBLEM_POINTER]; /* JSON pointer into the request, "" for all of it */
    char detail[PROBLEM_TEXT];
  } errors[PROBLEM_ERRORS_MAX];
} problem;

/* Makes *p a problem without errors. Text from a client may be part of `format`'s arguments: what
 * is not UTF-8 becomes '?', what does not fit is cut between characters. Messages say subject, got,
 * needed. */
void problem_begin(problem *p, int status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* The same with a type of its own. */
void problem_begin_type(problem *p, problem_type type, int status, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

/* Adds one culprit; from the 21st on they are only counted. */
void problem_add(problem *p, const char *pointer, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* The document: {"type","title","status","detail","errors":[{"pointer","detail"}]}; "errors" only
 * if there are any. malloc'ed, *size bytes and a NUL after them; NULL when out of memory. */
char *problem_bytes(const problem *p, size_t *size);

/* The detail as far as it fits into room[size], cut between words. */
void problem_shorten(const problem *p, char *room, size_t size);

/* Phrase of an HTTP status, "Not Found"; "Error" for one we never send. */
const char *problem_phrase(int status);

#endif
