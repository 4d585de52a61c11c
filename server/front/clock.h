/* clock.h - when somebody sets the time of day.
 *
 * What is kept for a time is stored with the date at which that ends, because it has to outlive the
 * daemon. So when the time of day is set while the daemon runs, these dates are moved with it: what
 * had an hour left has an hour left; until that is stored unix_now goes on as before. All that
 * waits within the process goes by loop_now, which nobody sets. Smaller steps than 10 s are just
 * followed.
 *
 * Daemons that share a store go by its database's clock, whatever their own one shows: they ask it
 * when they start and with every beat. Test: http.clock, http.clock.postgres.
 */
#ifndef SCATTERD_CLOCK_H
#define SCATTERD_CLOCK_H

#include "service.h"

typedef struct clock_watch clock_watch;

/* Watches from now on; what `s` points to is used when the clock is set. NULL when out of memory.
 */
clock_watch *clock_watch_new(loop *l, const service *s);
void clock_watch_free(clock_watch **w);

/* Has it been set since the last look? Then dates are moved. Called before a request is looked at;
 * the loop calls it too. */
void clock_watch_look(clock_watch *w);

#endif
