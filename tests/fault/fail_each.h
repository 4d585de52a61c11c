/* fail_each.h - an entry of the library whose memory runs out at every allocation in turn. */
#ifndef FAIL_EACH_H
#define FAIL_EACH_H

#include "scatter/status.h"

/* Calls the entry, and frees what it made. */
typedef sct_status attempt(sct_error *err);

/* Fails the n-th allocation of `run`, alone and with all after it, for every n: SCT_E_MEMORY each
 * time, also in err, and SCT_OK once none fails. `at_least` allocations must have been asked for,
 * or this test has lost sight of them. */
void fail_each(attempt *run, int at_least);

#endif
