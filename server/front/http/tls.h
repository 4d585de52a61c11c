/* tls.h - the certificate of this service: read, read again, given to each new connection: with
 * http.c's own use of a session the only door to GnuTLS. TLS 1.2 and 1.3. One at a time in a
 * process. Test: http.tls.
 */
#ifndef SCATTERD_TLS_H
#define SCATTERD_TLS_H

#include <stdbool.h>
#include <stddef.h>

#include "fault.h"

/* Reads certificate chain and key (PEM). Again: new connections get the new one, those that are
 * there keep theirs. False with the reason, and then all is as it was: what cannot be read, a key
 * of another certificate. */
bool tls_read(const char *certificate, const char *key, fault *why);
void tls_forget(void);

extern const char tls_priorities[]; /* which versions and ciphers, as GnuTLS has it */

/* What libmicrohttpd asks for a certificate, a gnutls_certificate_retrieve_function2. */
void *tls_source(void);

/* Sends as much of some bytes as goes now through a gnutls_session_t. */
void tls_send(void *session, const void *bytes, size_t size);

#endif
