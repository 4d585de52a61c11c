/* exhaust.h - one request answered again and again, each time with another allocation failing. */
#ifndef EXHAUST_H
#define EXHAUST_H

#include "unit/asking.h"

/* Answers once with all the memory there is, then with allocation first, first + stride, ...
 * failing, alone or (`lasting`) with all after it, until there are no more. The answer must be the
 * first one's status, a problem about limits (413, 422), or none for lack of memory. Returns how
 * many failed. Leaks are LeakSanitizer's to find. */
int64_t exhaust_each(const ask *question, bool lasting, int64_t first, int64_t stride);

#endif
