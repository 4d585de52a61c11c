/* fail_alloc.h - makes the n-th allocation fail.
 *
 * Link with fail_alloc.c and the option -Wl,--wrap=malloc,--wrap=calloc,--wrap=realloc: allocations
 * of the objects linked statically (ours) pass through here, those within shared libraries do not.
 */
#ifndef TESTS_FAULT_FAIL_ALLOC_H
#define TESTS_FAULT_FAIL_ALLOC_H

#include <stdint.h>

/* The n-th allocation from now on (0: the next) fails, the others work. -1: none fails. */
void fail_alloc_at(int64_t n);

/* Allocations asked for since fail_alloc_at; more than n: the n-th has failed. */
int64_t fail_alloc_count(void);

#endif
