/* credential.h - what stands in the field Authorization: a bearer token (RFC 6750), or a name and
 * its secret (HTTP Basic, RFC 7617). Test: unit.credential, fuzz.token.
 */
#ifndef SCATTERD_CREDENTIAL_H
#define SCATTERD_CREDENTIAL_H

#include "token.h"

/* Whose credentials they are: NULL with errno 0 for all that are not good ones of a token, whatever
 * is wrong with them; NULL with ENOMEM when that cannot be known now. */
token *credential_find(tokens *t, const char *field);

#endif
