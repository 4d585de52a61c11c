/* instant.h - times as RFC 3339 has them, and intervals of them. Test: unit.instant.
 */
#ifndef SCATTERD_INSTANT_H
#define SCATTERD_INSTANT_H

#include <stdbool.h>

/* "2026-11-22T17:50:09.5Z", "2026-11-22T18:50:09+01:00", "2026-11-22" as the interval (seconds
 * since 1970) that it means: an instant to its precision, a day from its start to its end (UTC). */
bool instant_read(const char *text, int length, double *first, double *last);

/* One of those, or "first/last", where ".." or nothing is an open end. */
bool instant_interval(const char *text, double *first, double *last);

#endif
