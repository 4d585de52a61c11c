/* Parameters and columns of statements. */
#include <endian.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "store_postgres.h"
#include "utf8.h"

/* ---- Parameters ---- */

/* A copy with what is no UTF-8 as '?': the database takes nothing else. */
static char *cleaned(const char *text) {
  char *copy = strdup(text);
  for (char *at = copy, *end = copy != NULL ? copy + strlen(copy) : NULL; at < end;) {
    const size_t step_size = utf8_step(at, end);
    if (step_size == 0) *at = '?';
    at += step_size > 0 ? step_size : 1;
  }
  return copy;
}

void postgres_bind_text(store *s, statement k, int place, const char *text) {
  postgres *b = postgres_of(s);
  const size_t length = strlen(text);
  (void)k;
  if (utf8_prefix(text, length) < length) text = b->clean[place - 1] = cleaned(text);
  b->value[place - 1] = text;
}

void postgres_bind_long(store *s, statement k, int place, int64_t value) {
  postgres *b = postgres_of(s);
  (void)k;
  snprintf(b->number[place - 1], sizeof *b->number, "%lld", (long long)value);
  b->value[place - 1] = b->number[place - 1];
}

void postgres_bind_real(store *s, statement k, int place, double value) {
  postgres *b = postgres_of(s);
  (void)k;
  snprintf(b->number[place - 1], sizeof *b->number, isinf(value) ? "%finity" : "%.17g", value);
  b->value[place - 1] = b->number[place - 1];
}

void postgres_bind_bytes(store *s, statement k, int place, const void *bytes, size_t size) {
  postgres *b = postgres_of(s);
  (void)k;
  b->value[place - 1] = size > 0 ? bytes : "";
  b->length[place - 1] = (int)size;
  b->is_bytes[place - 1] = 1;
}

void postgres_unbind(postgres *b) {
  for (int p = 0; p < POSTGRES_PARAMETERS; p++) {
    free(b->clean[p]);
    b->clean[p] = NULL;
    b->value[p] = NULL;
    b->length[p] = b->is_bytes[p] = 0;
  }
}

/* ---- Columns: numbers are big-endian, of 4 or 8 bytes ---- */

int64_t postgres_changes(store *s, statement k) {
  return strtoll(PQcmdTuples(postgres_of(s)->result[k]), NULL, 10);
}

bool postgres_is_null(store *s, statement k, int c) {
  const postgres *b = postgres_of(s);
  return PQgetisnull(b->result[k], b->row[k], c) != 0;
}

static uint64_t bits(const postgres *b, statement k, int c) {
  const char *at = PQgetvalue(b->result[k], b->row[k], c);
  uint32_t four = 0;
  uint64_t eight = 0;
  if (PQgetlength(b->result[k], b->row[k], c) == 8) {
    memcpy(&eight, at, sizeof eight);
    return be64toh(eight);
  }
  if (PQgetlength(b->result[k], b->row[k], c) == 4) memcpy(&four, at, sizeof four);
  return (uint64_t)(int32_t)be32toh(four);
}

int64_t postgres_get_long(store *s, statement k, int c) {
  return (int64_t)bits(postgres_of(s), k, c);
}

double postgres_get_real(store *s, statement k, int c) {
  enum { FLOAT8 = 701 }; /* its number in every PostgreSQL */
  const postgres *b = postgres_of(s);
  const uint64_t raw = bits(b, k, c);
  double value;
  if (PQftype(b->result[k], c) != FLOAT8) return (double)(int64_t)raw;
  memcpy(&value, &raw, sizeof value);
  return value;
}

const void *postgres_get_bytes(store *s, statement k, int c, size_t *size) {
  const postgres *b = postgres_of(s);
  *size = (size_t)PQgetlength(b->result[k], b->row[k], c);
  return PQgetvalue(b->result[k], b->row[k], c);
}
