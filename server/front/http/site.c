#include "site.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "document.h"
#include "negotiate.h"

static const char mark[] = "{B}";

static const document *find(const char *name) {
  for (size_t k = 0; k < document_count; k++) {
    if (strcmp(documents[k].name, name) == 0) return &documents[k];
  }
  return NULL;
}

static int64_t marks_in(const document *d) {
  int64_t count = 0;
  for (const char *at = d->bytes; (at = strstr(at, mark)) != NULL; at += strlen(mark)) count++;
  return count;
}

/* A copy of the document with `base` for every mark, malloc'ed; NULL when out of memory. */
static char *fill(const document *d, const char *base, size_t *size) {
  const size_t length = strlen(base);
  char *copy = malloc(d->size + (size_t)marks_in(d) * length + 1), *to = copy;
  if (copy == NULL) return NULL;
  const char *from = d->bytes;
  for (const char *at; (at = strstr(from, mark)) != NULL; from = at + strlen(mark)) {
    to = mempcpy(to, from, (size_t)(at - from));
    to = mempcpy(to, base, length);
  }
  to = mempcpy(to, from, d->size - (size_t)(from - d->bytes));
  *size = (size_t)(to - copy);
  return copy;
}

void site_serve(exchange *x, const char *name, const char *type) {
  const document *d = find(name);
  size_t size;
  if (d == NULL) {
    exchange_refuse(x, 404, "there is no %.100s", name);
    return;
  }
  char *bytes = fill(d, x->base, &size);
  if (bytes == NULL) {
    exchange_refuse(x, 503, "out of memory");
    return;
  }
  exchange_bytes(x, 200, type, bytes, size);
  negotiate_coding(x);
}

void site_serve_page(exchange *x, const char *name) {
  exchange_add(x, "Content-Security-Policy",
               "default-src 'none'; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; "
               "form-action 'none'; frame-ancestors 'self'");
  exchange_add(x, "X-Content-Type-Options", "nosniff");
  exchange_add(x, "Referrer-Policy", "no-referrer");
  site_serve(x, name, "text/html; charset=utf-8");
}

void site_processes(exchange *x, int64_t limit) {
  char name[64];
  snprintf(name, sizeof name, "processes-%lld.json", (long long)limit);
  site_serve(x, find(name) != NULL ? name : "processes.json", media_type(MEDIA_JSON));
}

bool site_has_process(const char *id) {
  char name[128];
  snprintf(name, sizeof name, "processes/%s.json", id);
  return find(name) != NULL;
}
