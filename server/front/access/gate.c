#include "gate.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "credential.h"
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

/* ---- What an owner may keep ---- */

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
  token *t = field != NULL ? credential_find(g->tokens, field) : NULL;
  if (t == NULL) {
    if (field != NULL && errno == ENOMEM) {
      exchange_refuse(x, 503, "out of memory");
    } else {
      refuse_stranger(x);
    }
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
