#include "data_url.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base64.h"

bool data_url_is(const char *url) {
  return strncasecmp(url, "data:", 5) == 0;
}

static int hex(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

/* Undoes percent-encoding in place; what is no escape stands for itself. */
static size_t unescape(char *text, size_t length) {
  size_t to = 0;
  for (size_t k = 0; k < length; k++, to++) {
    bool is_escape =
        text[k] == '%' && length - k > 2 && hex(text[k + 1]) >= 0 && hex(text[k + 2]) >= 0;
    text[to] = is_escape ? (char)(hex(text[k + 1]) * 16 + hex(text[k + 2])) : text[k];
    if (is_escape) k += 2;
  }
  return to;
}

/* The type without its parameters; *is_base64 if the last of them is that. */
static bool read_type(const char *type, size_t length, media *form, bool *is_base64) {
  char room[128];
  if (length >= sizeof room) return false;
  memcpy(room, type, length);
  room[length] = '\0';
  const char *last = strrchr(room, ';');
  *is_base64 = last && !strcasecmp(last, ";base64");
  room[strcspn(room, ";")] = '\0';
  *form = MEDIA_JSON;
  return !*room || !strcasecmp(room, "text/plain") || media_find(room, form);
}

bool data_url_read(const char *url, media *form, unsigned char **bytes, size_t *size,
                   const char **why) {
  const char *type = url + 5, *comma = strchr(type, ',');
  bool is_base64 = false;
  long long decoded = 0;
  *bytes = NULL;
  *why = "has no comma between type and data";
  if (!comma) return false;
  *why = "is of a media type that is unknown here";
  if (!read_type(type, (size_t)(comma - type), form, &is_base64)) return false;
  *why = NULL;
  char *text = strdup(comma + 1);
  if (!text) return false;
  *size = unescape(text, strlen(text));
  *bytes = (unsigned char *)text;
  if (!is_base64) return true;
  *bytes = base64_decode(text, *size, &decoded);
  free(text);
  if (*bytes && decoded < 0) *why = "is no base64";
  *size = decoded < 0 ? 0 : (size_t)decoded;
  return *bytes && decoded >= 0;
}
