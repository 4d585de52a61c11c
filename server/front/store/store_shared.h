/* store_shared.h - what a store does that several daemons share: who lives, who has which job, what
 * they tell each other. Only for a store that store_is_shared.
 *
 * A daemon is known by its holder id, which is in the row of every job that it has taken. It beats;
 * one that has not for `lease` seconds, by the database's clock, has nothing any more. A job is
 * changed only by its holder, which is checked with every change, or by whoever dismisses it.
 * Test: unit.store.postgres, http.daemons.
 */
#ifndef SCATTERD_STORE_SHARED_H
#define SCATTERD_STORE_SHARED_H

#include "store.h"

/* ---- The connection ---- */

/* Goes on with connecting if it has to; does it work? Never waits for it. */
bool store_tend(store *s);

/* Readable when there is something to hear; -1 without a connection. Another number of *generation
 * is another descriptor. */
int store_descriptor(const store *s, int *generation);

/* Something another daemon told, malloc'ed; NULL for no more. */
char *store_hear(store *s);

/* Is there something that came while a statement was waited for, so that the descriptor is silent?
 */
bool store_has_news(const store *s);

/* Tells the others, with the transaction if there is one. Less than 8000 bytes. */
store_result store_tell(store *s, const char *text);

/* This transaction is committed without waiting for the disk: should the database crash within the
 * next second, it has not happened. */
store_result store_relax(store *s);

/* ---- Daemons ---- */

/* Who this one is, for as long as the store is open: its drafts are called after it. */
void store_sign(store *s, const char *holder);

/* The database's clock, in seconds since 1970. */
store_result store_clock(store *s, double *now);

/* This daemon lives. *now is the database's clock, in seconds since 1970. */
store_result store_beat(store *s, const char *holder, double *now);

/* It ends: what it took and has not begun is free again. */
void store_leave(store *s, const char *holder);

/* Frees what dead daemons took, calls too, claims for `holder` what they were running, forgets
 * them.
 */
store_result store_bury(store *s, const char *holder, double lease);

/* ---- Jobs ---- */

/* The job whose turn it is, for `holder`: one that needs at most `room` bytes of memory, or was
 * accepted before `old`. Of one priority the submitters take turns, each with its oldest job; what
 * another daemon is taking at the moment is passed over. */
store_result store_take(store *s, const char *holder, int64_t room, double old, job_row *row);

/* Takes one job as it was read: of no holder and in row->state. STORE_NONE if it is not so. */
store_result store_claim(store *s, const char *holder, const job_row *row);

/* All that a holder has. */
store_result store_held(store *s, const char *holder, store_visit *visit, void *context);

/* How many wait for a holder; -1 if that cannot be read. */
int64_t store_waiting(store *s);

/* How many jobs of a submitter are not over, batches by their parts. */
int64_t store_active_of(store *s, const char *submitter);

/* Until the transaction ends nobody else adds jobs of a submitter who has to be counted. Of several
 * submitters in the order of their names, or two daemons wait for each other. */
store_result store_lock_jobs(store *s, const char *submitter);

/* Progress, message, phase and residual of a running job; STORE_NONE if row->holder has it no more.
 */
store_result store_progress(store *s, const job_row *row);

/* ---- Batches ---- */

bool store_has_active_part(store *s, int64_t parent);
double store_part_progress(store *s, int64_t parent); /* mean of the parts, per cent */

/* Batches whose parts are all over and that nobody has. */
store_result store_done_batches(store *s, store_visit *visit, void *context);

/* Dismisses all parts that are not over. */
store_result store_dismiss_parts(store *s, int64_t parent, double now);

/* ---- Calls to subscribers ---- */

/* As store_update_call, if call->attempts is one more than it is; else STORE_NONE. It is due again
 * when `holder` dies. */
store_result store_claim_call(store *s, const char *holder, const job_call *call);

#endif
