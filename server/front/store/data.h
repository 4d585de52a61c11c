/* data.h - objects under /data: clouds and arrays uploaded once for many requests, and outputs by
 * reference. Content-addressed: the id is the SHA-256 of the bytes, so the same upload twice is one
 * object. Where there are tokens each owner has objects of its own: the id is the digest of owner
 * and bytes, so nobody sees, finds out, keeps or removes what somebody else has uploaded. They
 * expire, but not while a job that refers to them waits or runs. Test: http.data.
 */
#ifndef SCATTERD_DATA_H
#define SCATTERD_DATA_H

#include "loop.h"
#include "param.h"
#include "store.h"

typedef struct data_store data_store;

/* Drops files that no row knows (a daemon ended while it wrote one). NULL when out of memory. */
data_store *data_new(loop *l, const parameters *set, store *s);
void data_free(data_store **d);

typedef enum {
  DATA_NEW,
  DATA_KNOWN,  /* the same bytes were there: they stay longer now */
  DATA_OTHER,  /* ... but as another media type */
  DATA_QUOTA,  /* no room within data-bytes, or what the owner may have */
  DATA_FULL,   /* no room on the disk */
  DATA_DOWN,   /* the database does not answer */
  DATA_FAILED, /* the log knows */
} data_result;

/* Whose objects, and how many bytes they may be in all. Without tokens the owner is "". */
typedef struct {
  const char *name;
  int64_t bytes;
} data_owner;

/* Keeps the first `size` bytes of fd for an owner, durably. *row is the object, also if it is
 * DATA_OTHER. Cost: a SHA-256 and, for a new one, a copy and three fsyncs. */
data_result data_add(data_store *d, data_owner owner, const char *type, int fd, size_t size,
                     data_row *row);

/* STORE_NONE for an id that is none, and for an object of somebody else (of anybody, if `owner` is
 * ""), too. */
store_result data_find(data_store *d, const char *owner, const char *id, data_row *row);

/* Opens the bytes of an object for reading; -1 with errno. */
int data_open(data_store *d, const data_row *row);

/* The time of day was set by so many seconds, and the dates of the store with it (clock.h). */
void data_shift(data_store *d, double by);

/* STORE_FULL: a job needs it; STORE_NONE: it has gone. */
store_result data_drop(data_store *d, const data_row *row);

#endif
