/* data.h - objects under /data: clouds and arrays uploaded once for many requests, and outputs by
 * reference. Content-addressed: the id is the SHA-256 of the bytes, so the same upload twice is one
 * object. Where there are tokens each owner has objects of its own: the id is the digest of owner
 * and bytes, so nobody sees, finds out, keeps or removes what somebody else has uploaded. They
 * expire, but not while a job that refers to them waits or runs. Test: http.data.
 */
#ifndef SCATTERD_DATA_H
#define SCATTERD_DATA_H

#include "clerk.h"
#include "loop.h"
#include "param.h"
#include "store.h"

typedef struct data_store data_store;

/* Drops files that no row knows (a daemon ended while it wrote one). NULL when out of memory. */
data_store *data_new(loop *l, const parameters *set, store *s, clerk *k);

/* After clerk_finish, with nobody left who waits. */
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

/* Bytes on their way to be an object. */
typedef struct data_filing data_filing;

typedef struct {
  data_owner owner;
  const char *type;
  int fd;      /* -1 if there are no bytes */
  size_t size; /* its first bytes are meant */
  /* Called once. *row is the object if it is DATA_NEW, DATA_KNOWN or DATA_OTHER, else what would
   * have been one. */
  void (*done)(void *self, data_result result, const data_row *row);
  void *self;
} data_order;

/* Keeps bytes for an owner, durably: they are hashed and written aside (clerk.h), and count within
 * the quotas meanwhile; the same bytes coming twice at a time are one object. Takes o->fd in any
 * case. *filing is set until `done` is called, which may be before this returns, and then NULL.
 * Cost: a SHA-256 and, for a new one, a copy and three fsyncs, of which the loop waits for the one
 * of the row (in a shared store for all of bytes that are not for the clerk). */
void data_add(data_store *d, const data_order *o, data_filing **filing);

/* Nobody wants it any more: `done` is not called, and no object is made of it. *filing is NULL. */
void data_forget(data_filing **filing);

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
