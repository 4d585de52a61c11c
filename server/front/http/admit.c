#include "admit.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

typedef void check(exchange *x, const head *h, const parameters *set, host_rule rule);

static void check_size(exchange *x, const head *h, const parameters *set, host_rule rule) {
  (void)rule;
  const size_t most = (size_t)set->header_bytes, target = strlen(x->target);
  if (target > most / 2) {
    exchange_refuse(x, 414, "target: got %zu bytes, needs at most %zu (half of header-bytes)",
                    target, most / 2);
  } else if (h->size > most) {
    exchange_refuse(x, 431, "header: got %zu bytes, needs at most %zu (header-bytes)", h->size,
                    most);
  }
}

static void check_fields(exchange *x, const head *h, const parameters *set, host_rule rule) {
  (void)set, (void)rule;
  if (!h->broken) return;
  exchange_refuse(x, 400,
                  "header: got a line that continues another, or has no name before its colon, "
                  "or a blank or NUL in it");
}

static void check_target(exchange *x, const head *h, const parameters *set, host_rule rule) {
  (void)h, (void)set, (void)rule;
  if (exchange_find_path(x)) return;
  exchange_refuse(x, 400, "target: got \"%.100s\", needs a path without broken escapes", x->target);
}

static void check_host(exchange *x, const head *h, const parameters *set, host_rule rule) {
  if (h->hosts == 0 && h->old) return;
  if (h->hosts != 1 || !exchange_is_host(h->host)) {
    exchange_refuse(x, 400, "Host: got %d of them (\"%.100s\"), needs one name or address",
                    h->hosts, h->hosts > 0 ? h->host : "");
  } else if (!host_allows(rule, set, h->host)) {
    exchange_refuse(x, 421, "Host: got \"%.100s\", by which this service is not called (hosts)",
                    h->host);
  }
}

/* A length in two versions is how requests are smuggled past a proxy. */
static void check_framing(exchange *x, const head *h, const parameters *set, host_rule rule) {
  (void)set, (void)rule;
  if (h->lengths + h->codings > 1) {
    exchange_refuse(x, 400, "body: its length is given %d times", h->lengths + h->codings);
  } else if (h->coding != NULL && strcasecmp(h->coding, "chunked") != 0) {
    exchange_refuse(x, 501, "Transfer-Encoding: got \"%.100s\", needs chunked", h->coding);
  }
}

static void check_length(exchange *x, const head *h, const parameters *set, host_rule rule) {
  (void)h, (void)rule;
  if (x->declared <= set->limits.body_bytes) return;
  exchange_refuse(x, 413, "body: got %lld bytes, needs at most %lld (body-bytes)",
                  (long long)x->declared, (long long)set->limits.body_bytes);
}

static check *const checks[] = {check_size, check_fields,  check_target,
                                check_host, check_framing, check_length};

/* Links are absolute: they begin with the configured URL, or with the Host the client used. */
static void set_base(exchange *x, const head *h, const parameters *set, const char *host) {
  const char *scheme = *set->tls_certificate != '\0' ? "https" : "http";
  if (h->hosts > 0 && exchange_is_host(h->host)) host = h->host;
  if (*set->public_url == '\0') {
    snprintf(x->base, sizeof x->base, "%s://%s", scheme, host);
    return;
  }
  snprintf(x->base, sizeof x->base, "%s", set->public_url);
  for (size_t end = strlen(x->base); end > 0 && x->base[end - 1] == '/';) x->base[--end] = '\0';
}

bool admit(exchange *x, const head *h, const parameters *set, const http_place *place) {
  x->plain_problem = media_names(h->accept, media_type(MEDIA_JSON)) &&
                     !media_names(h->accept, media_type(MEDIA_PROBLEM));
  snprintf(x->method, sizeof x->method, "%s", h->method);
  if (h->id != NULL) exchange_identify(x, h->id);
  set_base(x, h, set, place->host);
  x->has_body = h->coding != NULL || h->length != NULL || h->broken; /* there may be one */
  x->body_most = set->limits.body_bytes;
  x->declared = h->coding != NULL ? -1 : h->length != NULL ? strtoll(h->length, NULL, 10) : 0;
  for (size_t k = 0; k < sizeof checks / sizeof *checks; k++) {
    checks[k](x, h, set, place->rule);
    if (x->reply.status != 0) return false;
  }
  return true;
}
