#include "seam.h"

#include <ctype.h>
#include <stddef.h>
#include <string.h>

static bool is_token(const char *name) {
  const char *at = name;
  while (isalnum((unsigned char)*at) || (*at != '\0' && strchr("!#$%&'*+-.^_`|~", *at) != NULL))
    at++;
  return at > name && *at == '\0';
}

/* Behind the NUL that took the place of the colon there are blanks, then the value. */
static bool is_joined(const char *name, const char *value) {
  const char *at = name + strlen(name) + 1;
  while (at < value && (*at == ' ' || *at == '\t')) at++;
  return at == value;
}

/* Are from and to as far apart as so many ends of lines, each CR LF or LF? */
static bool are_lines(const char *from, const char *to, ptrdiff_t lines) {
  return to - from >= lines && to - from <= 2 * lines;
}

void seam_field(seam *s, const char *name, const char *value) {
  const bool follows = s->end == NULL || are_lines(s->end, name, 1);
  if (!is_token(name)) s->is_broken = true;
  if (s->is_strict && !(follows && is_joined(name, value))) s->is_broken = true;
  s->end = value + strlen(value);
}

void seam_end(seam *s, const char *end) {
  if (s->is_strict && s->end != NULL && !are_lines(s->end, end, 2)) s->is_broken = true;
}
