/* fail_alloc.h - makes the n-th allocation of the program's own objects fail.
 *
 * Link with fail_alloc.c and -Wl,--wrap=malloc,--wrap=calloc,--wrap=realloc. Packages in shared
 * libraries are not touched, unless they are handed malloc, calloc and realloc as pointers: the
 * pointers taken in the test are those that fail. */
#ifndef TESTS_FAIL_ALLOC_H
#define TESTS_FAIL_ALLOC_H

#include <stdbool.h>
#include <stdint.h>

/* The n-th allocation from now on returns NULL, the others work. 0: none. */
void fail_alloc_at(int64_t n);

/* Has it come to the n-th? */
bool fail_alloc_hit(void);

#endif
