#include "callback.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "problem.h"

static const char *const members[] = {"successUri", "inProgressUri", "failedUri"};

/* Host and port of an http or https address; length 0 if it is none. User names are not wanted. */
static size_t authority(const char *uri, const char **at) {
  const size_t scheme = strncasecmp(uri, "http://", 7) == 0    ? 7
                        : strncasecmp(uri, "https://", 8) == 0 ? 8
                                                               : 0;
  if (scheme == 0) return 0;
  *at = uri + scheme;
  const size_t length = strcspn(*at, "/?#");
  return memchr(*at, '@', length) == NULL && memchr(*at, '\\', length) == NULL ? length : 0;
}

static bool is_allowed(const char *hosts, const char *uri) {
  const char *host = "";
  const size_t length = authority(uri, &host);
  for (const char *at = hosts; *at != '\0' && length > 0;) {
    at += strspn(at, " ,");
    const size_t step = strcspn(at, " ,");
    if (step == length && strncasecmp(at, host, length) == 0) return true;
    at += step;
  }
  return false;
}

bool callback_allows(const service *s, exchange *x, const job_extra *extra) {
  problem p;
  char pointer[64];
  problem_begin(&p, 400, "subscriber: an address is not allowed (callback-hosts)");
  for (int k = 0; k < 3; k++) {
    if (*extra->uri[k] == '\0' || is_allowed(s->set->callback_hosts, extra->uri[k])) continue;
    snprintf(pointer, sizeof pointer, "/subscriber/%s", members[k]);
    problem_add(&p, pointer,
                "got \"%.200s\", needs http:// or https:// and a host among \"%.200s\"",
                extra->uri[k], s->set->callback_hosts);
  }
  if (p.count > 0) exchange_problem(x, &p);
  return p.count == 0;
}
