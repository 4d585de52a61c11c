#include "credential.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base64.h"

/* NAME:SECRET in base64. Whoever has a secret may know which name it is of; nobody else learns
 * which of the two was wrong. */
static token *of_basic(tokens *t, const char *text) {
  long long size = -1;
  token *found = NULL;
  char *pair = (char *)base64_decode(text, strlen(text), &size);
  char *copy = pair != NULL && size >= 0 ? strndup(pair, (size_t)size) : NULL, *secret = copy;
  if (pair == NULL || (size >= 0 && copy == NULL)) errno = ENOMEM;
  if (copy != NULL && strlen(copy) == (size_t)size) {
    const char *name = strsep(&secret, ":");
    found = secret != NULL ? tokens_holding(t, secret) : NULL;
    if (found != NULL && strcmp(found->name, name) != 0) found = NULL;
  }
  free(copy);
  free(pair);
  return found;
}

static const struct {
  const char *name;
  token *(*find)(tokens *t, const char *text);
} schemes[] = {{"Bearer", tokens_holding}, {"Basic", of_basic}};

token *credential_find(tokens *t, const char *field) {
  errno = 0;
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
