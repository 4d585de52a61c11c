/* member.h - members of an object that is being written. Test: unit.emit. */
#ifndef SCATTERD_MEMBER_H
#define SCATTERD_MEMBER_H

#include "emit.h"

void member_number(emit *e, const char *key, double value); /* left out where not finite */
void member_integer(emit *e, const char *key, int64_t value);
void member_text(emit *e, const char *key, const char *value); /* left out where NULL */
void member_bool(emit *e, const char *key, bool value);
void member_object(emit *e, const char *key); /* begins one */
void member_doubles(emit *e, const char *key, const double *value, int64_t n);

/* An array of numbers [n], and one of rows [n][components]. */
void emit_array(emit *e, const double *value, int64_t n);
void emit_rows(emit *e, const double *value, int64_t n, int components);

#endif
