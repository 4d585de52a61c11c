#include "gate.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base64.h"
#include "http.h"
#include "log.h"
#include "loop.h"

struct gate {
  const parameters *set;
  tokens *tokens; /* NULL: everybody */
};

/* ---- The file ---- */

static tokens *read_file(const gate *g, fault *why) {
  bool is_public = false;
  tokens *t = tokens_read(g->set->tokens, g->tokens, &is_public, why);
  if (t != NULL && is_public) {
    log_say(LOG_ERROR, "tokens", "%s may be read by everybody on this machine; chmod o= it",
            g->set->tokens);
  }
  return t;
}

gate *gate_new(const parameters *set, fault *why) {
  gate *g = calloc(1, sizeof *g);
  if (g == NULL) {
    fault_set(why, "out of memory");
    return NULL;
  }
  g->set = set;
  if (*set->tokens == '\0') return g;
  g->tokens = read_file(g, why);
  if (g->tokens == NULL) gate_free(&g);
  return g;
}

void gate_free(gate **g) {
  if (*g == NULL) return;
  tokens_free(&(*g)->tokens);
  free(*g);
  *g = NULL;
}

bool gate_reload(gate *g, fault *why) {
  if (g->tokens == NULL) return true;
  tokens *t = read_file(g, why);
  if (t == NULL) return false;
  tokens_free(&g->tokens);
  g->tokens = t;
  log_say(LOG_INFO, "tokens", "%d of them", tokens_count(t));
  return true;
}

bool gate_is_on(const gate *g) {
  return g->tokens != NULL;
}

/* ---- Credentials ---- */

static token *of_bearer(tokens *t, const char *text) {
  return tokens_holding(t, text);
}

/* NAME:SECRET in base64. Whoever has a secret may know which name it is of; nobody else learns
 * which of the two was wrong. */
static token *of_basic(tokens *t, const char *text) {
  long long size = -1;
  token *found = NULL;
  char *pair = (char *)base64_decode(text, strlen(text), &size);
  if (pair != NULL && size > 0 && memchr(pair, '\0', (size_t)size) == NULL) {
    char *copy = strndup(pair, (size_t)size), *secret = copy;
    const char *name = strsep(&secret, ":");
    found = secret != NULL ? tokens_holding(t, secret) : NULL;
    if (found != NULL && strcmp(found->name, name) != 0) found = NULL;
    free(copy);
  }
  free(pair);
  return found;
}

static const struct {
  const char *name;
  token *(*find)(tokens *t, const char *text);
} schemes[] = {{"Bearer", of_bearer}, {"Basic", of_basic}};

/* NULL for anything but good credentials. */
static token *find(tokens *t, const char *field) {
  const size_t length = strcspn(field, " ");
  const char *text = field + length + strspn(field + length, " ");
  for (size_t k = 0; k < sizeof schemes / sizeof *schemes; k++) {
    if (strlen(schemes[k].name) != length || strncasecmp(field, schemes[k].name, length) != 0) {
      continue;
    }
    return schemes[k].find(t, text);
  }
  return NULL;
}

bool gate_keep(gate *g, const char *submitter, int64_t size, const allowance_counter *counter) {
  token *t = g->tokens != NULL ? tokens_named(g->tokens, submitter) : NULL;
  if (t == NULL || t->most.job_bytes == INT64_MAX) return true;
  return allowance_take(&t->kept, size, t->most.job_bytes, loop_now(), counter);
}

int64_t gate_data_bytes(const gate *g, const char *owner) {
  const token *t = g->tokens != NULL ? tokens_named(g->tokens, owner) : NULL;
  return t != NULL ? t->most.data_bytes : INT64_MAX;
}

/* ---- A request ---- */

static void refuse_stranger(exchange *x) {
  exchange_add(x, "WWW-Authenticate", "Bearer realm=\"scatterd\"");
  exchange_add(x, "WWW-Authenticate", "Basic realm=\"scatterd\", charset=\"UTF-8\"");
  exchange_refuse(x, 401,
                  "this service wants a token: its secret as bearer token, or its name and "
                  "secret as user and password (HTTP Basic)");
}

static bool is_patient(token *t, exchange *x) {
  const double wait =
      isinf(t->most.rate) ? 0 : bucket_take(&t->bucket, t->most.rate, t->most.burst, loop_now());
  if (wait <= 0) return true;
  exchange_add(x, "Retry-After", "%.0f", fmax(1, ceil(wait)));
  exchange_refuse(x, 429, "more requests than %g per second (limit: rate of the token)",
                  t->most.rate);
  return false;
}

bool gate_check(gate *g, exchange *x) {
  char room[512];
  if (g->tokens == NULL) return true;
  const char *field = http_field(x, "Authorization", room, sizeof room);
  token *t = field != NULL ? find(g->tokens, field) : NULL;
  if (t == NULL) {
    refuse_stranger(x);
    return false;
  }
  snprintf(x->owner, sizeof x->owner, "%s", t->name);
  x->most = t->most;
  if (t->most.body_bytes < x->body_most) x->body_most = t->most.body_bytes;
  if (!is_patient(t, x)) return false;
  if (x->declared <= x->body_most) return true;
  exchange_refuse(x, 413, "body: got %lld bytes, needs at most %lld (body-bytes of the token)",
                  (long long)x->declared, (long long)x->body_most);
  return false;
}

void gate_ask(const gate *g, const exchange *x, ipc_ask *ask) {
  ask->limits = g->set->limits;
  token_narrow(&x->most, &ask->limits);
  snprintf(ask->owner, sizeof ask->owner, "%s", x->owner);
}

void gate_ask_again(const gate *g, const char *submitter, ipc_ask *ask) {
  if (g->tokens == NULL) return;
  const token *t = tokens_named(g->tokens, submitter);
  if (t != NULL) token_narrow(&t->most, &ask->limits);
  snprintf(ask->owner, sizeof ask->owner, "%s", submitter);
}
