/* gate.h - who sends a request, and may they? Without a file of tokens everybody may do
 * everything. With one a request carries a secret, as a bearer token (RFC 6750) or as the password
 * of its token's name (HTTP Basic, RFC 7617); what it makes belongs to that name.
 * Test: http.access.
 */
#ifndef SCATTERD_GATE_H
#define SCATTERD_GATE_H

#include "allowance.h"
#include "exchange.h"
#include "ipc.h"
#include "param.h"

typedef struct gate gate;

/* Reads the file of tokens, if there is one. NULL with the reason. */
gate *gate_new(const parameters *set, fault *why);
void gate_free(gate **g);

/* Reads it again. False with the reason: then the old tokens hold on. */
bool gate_reload(gate *g, fault *why);

/* Are there tokens? */
bool gate_is_on(const gate *g);

/* Finds out who sends a request: sets owner and limits of *x. False if it is refused: the reply is
 * 401 or 429 then. */
bool gate_check(gate *g, exchange *x);

/* What a request may use, by its owner; its job later, by its submitter. */
void gate_ask(const gate *g, const exchange *x, ipc_ask *ask);
void gate_ask_again(const gate *g, const char *submitter, ipc_ask *ask);

/* May `size` bytes more of a submitter's jobs be kept? Then they are taken off what it may have. */
bool gate_keep(gate *g, const char *submitter, int64_t size, const allowance_counter *counter);

/* Bytes that an owner may have under /data; no limit without one. */
int64_t gate_data_bytes(const gate *g, const char *owner);

#endif
