/* token.h - who may use this service: a file with a line for each token,
 *
 *     alice sha256:64-HEX-DIGITS jobs=20 points=200000 seconds=60 body-bytes=16MiB rate=5
 *
 * its name, the SHA-256 of its secret (up to TOKEN_SECRETS of them, so that one can be replaced
 * while the old one still holds), and what it may use; # begins a comment. Secrets are 256 random
 * bits, made by `scatterd token NAME`: those cannot be guessed at whatever speed, so a fast hash is
 * enough, and one that is slow by design would only let strangers keep the front busy.
 * Test: unit.token, http.access.
 */
#ifndef SCATTERD_TOKEN_H
#define SCATTERD_TOKEN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "allowance.h"
#include "bucket.h"
#include "digest.h"
#include "fault.h"
#include "limit.h"

enum { TOKEN_NAME = 33, TOKEN_SECRET = 69, TOKEN_SECRETS = 4, TOKEN_LINE = 512 };

/* What one token may use. */
typedef struct {
  int64_t jobs;       /* executions waiting or running, jobs or not */
  int64_t points;     /* of a cloud */
  int64_t body_bytes; /* as sent */
  int64_t data_bytes; /* of its objects under /data, in all */
  int64_t job_bytes;  /* of the requests and results of its jobs, in all */
  int64_t streams;    /* event streams at the same time */
  double seconds;     /* of one solve */
  double rate, burst; /* requests per second; at once */
} token_limits;

extern const token_limits token_unlimited;

typedef struct {
  char name[TOKEN_NAME];
  unsigned char digest[TOKEN_SECRETS][DIGEST_BYTES]; /* of its secrets */
  int secrets;
  token_limits most;
  bucket bucket;
  allowance kept; /* of job_bytes */
} token;

typedef struct tokens tokens;

/* Reads the file: NULL with its line and the reason. A file that others than its owner may write is
 * refused. *is_public: may others read it? Requests left in the buckets of `old` (NULL: none) stay.
 */
tokens *tokens_read(const char *path, const tokens *old, bool *is_public, fault *why);
void tokens_free(tokens **t);
int tokens_count(const tokens *t);

/* The token of a name; the one that has this secret, in a time that does not depend on how much of
 * a wrong one is right. NULL if there is none. */
token *tokens_named(tokens *t, const char *name);
token *tokens_holding(tokens *t, const char *secret);

/* Makes a new token: its secret and its line of the file. `words` are limits as a line has them.
 * False with the reason. */
bool token_make(const char *name, int count, char **words, char secret[TOKEN_SECRET],
                char line[TOKEN_LINE], fault *why);

/* Lowers limits of a request to those of a token. */
void token_narrow(const token_limits *most, limits *l);

#endif
