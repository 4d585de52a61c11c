/* read.h - typed readers over a decoded document.
 *
 * An item is a value and where it stands, so that a complaint can point to it. Readers of an item
 * that is absent leave the output as it was and return true: set the default first, then read.
 * A reader that returns false has complained. Callers go on reading, so that all culprits are
 * found, and look at task_is_well in the end.
 * Proof: unit.read
 */
#ifndef SCATTERD_READ_H
#define SCATTERD_READ_H

#include "task.h"

typedef struct item item;
struct item {
  const doc *doc;  /* NULL: absent */
  const item *up;  /* what it stands in; NULL for the body. Must outlive this item */
  const char *key; /* member of `up`; NULL: an element */
  int64_t index;   /* element of `up` */
  bool wrapped;    /* found under {"value": ...}, which the pointer passes through */
};

item item_body(const doc *body);
item item_member(const item *of, const char *key);
item item_element(const item *of, const doc *element, int64_t index);

/* Member of the inputs of an execute request, bare or qualified as {"value": ...} with perhaps
 * mediaType, encoding or schema beside it (OGC API - Processes, "qualified value"). */
item item_input(const item *inputs, const char *key);

/* The same for an item at hand: steps into {"value": {...}} of an object. */
void item_unwrap(item *it);

/* Complains of members beside the value of an input that none of the above knows. */
bool read_qualified(task *t, const item *it);

/* A complaint about the value at `at`: "subject, got, needed"; none once memory ran out. */
void complain(task *t, const item *at, const char *format, ...) SCT_PRINTF(3, 4);

/* JSON pointer (RFC 6901) to an item; where it does not fit, to the last value around it that does.
 */
void item_pointer(const item *at, char pointer[PROBLEM_POINTER]);

/* What a number may be: low <= value <= high, or strictly so. */
typedef struct {
  double low, high;
  bool above, below; /* low, high themselves are not allowed */
} range;
extern const range range_any, range_positive, range_not_negative;

/* Complains that `kind` ("member") of that name is not among `names`, with the nearest of them. */
void complain_unknown(task *t, const item *it, const char *kind, const char *const *names);

/* Complains that a required item is absent; true if it is there. */
bool read_required(task *t, const item *it);

/* An object, whose members must be among `members` (NULL at the end; a NULL list: any). */
bool read_object(task *t, const item *it, const char *const *members);

bool read_number(task *t, const item *it, const range *r, double *value);
bool read_integer(task *t, const item *it, int64_t low, int64_t high, int64_t *value);
bool read_boolean(task *t, const item *it, bool *value);
bool read_text(task *t, const item *it, const char **value);

/* One of `names` (NULL at the end): its place in them. */
bool read_choice(task *t, const item *it, const char *const *names, int *value);

/* An array of finite numbers: rank 1 [rows], or rank 2 [rows][columns]. */
typedef struct {
  int64_t rows, columns; /* columns: 1 for rank 1 */
  const double *data;    /* [rows][columns], borrowed from the document */
} numbers;
bool read_numbers(task *t, const item *it, int rank, numbers *value);

/* A rank-1 array of integers, each from low to high. */
bool read_integers(task *t, const item *it, int64_t low, int64_t high, numbers *value);

/* Rank of the array that stands there as far as it can be told: 0 if it is none. */
int item_rank(const item *it);

/* The name among `names` closest to `name`, NULL if none is close. */
const char *nearest_name(const char *name, const char *const *names);

/* A client's text as it may stand in a message: cut at 40 bytes, at the boundary of a character. */
enum { SHOWN_MAX = 48 };
const char *shown(const char *text, char room[SHOWN_MAX]);

#endif
