#include "host.h"

#include <arpa/inet.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "ip.h"

enum { HOST_MOST = 256 };

/* Without port and brackets; false if it is too long to be one. */
static bool bare(const char *host, char room[HOST_MOST]) {
  const bool bracketed = *host == '[';
  const size_t length = bracketed ? strcspn(++host, "]") : strcspn(host, ":");
  if (length == 0 || length >= HOST_MOST) return false;
  memcpy(room, host, length);
  room[length] = '\0';
  if (!bracketed && length > 1 && room[length - 1] == '.') room[length - 1] = '\0';
  return true;
}

static bool is_local_name(const char *name) {
  const size_t length = strlen(name);
  return strcasecmp(name, "localhost") == 0 ||
         (length > 10 && strcasecmp(name + length - 10, ".localhost") == 0);
}

static bool fits(host_rule rule, const char *name) {
  ip a;
  if (rule == HOST_ANY || is_local_name(name)) return true;
  if (!ip_read(&a, name)) return false;
  return rule == HOST_ADDRESS || ip_is_loopback(&a);
}

static bool is_public(const parameters *set, const char *name) {
  char room[HOST_MOST];
  const char *at = strstr(set->public_url, "://");
  return at != NULL && bare(at + 3, room) && strncasecmp(room, name, strlen(name)) == 0 &&
         strcspn(room, "/") == strlen(name);
}

/* Calls `is` for each word of a list until one is. */
static bool any(const char *list, bool (*is)(const char *word, const char *what),
                const char *what) {
  char word[PARAM_TEXT];
  for (const char *at = list; *at != '\0';) {
    at += strspn(at, " ,");
    const size_t length = strcspn(at, " ,");
    snprintf(word, sizeof word, "%.*s", (int)length, at);
    if (length > 0 && (strcmp(word, "*") == 0 || is(word, what))) return true;
    at += length;
  }
  return false;
}

static bool is_host(const char *word, const char *name) {
  char room[HOST_MOST];
  return bare(word, room) && strcasecmp(room, name) == 0;
}

static bool is_text(const char *word, const char *text) {
  return strcmp(word, text) == 0;
}

bool host_allows(host_rule rule, const parameters *set, const char *host) {
  char name[HOST_MOST];
  if (rule == HOST_ANY) return true;
  if (!bare(host, name)) return false;
  return fits(rule, name) || is_public(set, name) || any(set->hosts, is_host, name);
}

bool host_lists(const char *list, const char *origin) {
  return any(list, is_text, origin);
}
