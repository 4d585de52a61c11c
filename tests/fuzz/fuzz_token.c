/* Any bytes as a file of tokens, what follows their first NUL as the fields Authorization and Host:
 * nothing breaks, what is read is within its bounds, and nobody gets in by the name of a token that
 * is not in the file. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "credential.h"
#include "fuzz.h"
#include "host.h"

enum { LONGEST = 4000 };

static void require(int holds, const char *what) {
  if (holds) return;
  fprintf(stderr, "does not hold: %s\n", what);
  abort();
}

static tokens *read_bytes(const void *bytes, size_t size) {
  char path[64];
  fault why = {.text = ""};
  bool is_public;
  const int fd = memfd_create("tokens", MFD_CLOEXEC);
  if (fd < 0 || write(fd, bytes, size) != (ssize_t)size) abort();
  snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
  fchmod(fd, 0600);
  tokens *t = tokens_read(path, NULL, &is_public, &why);
  close(fd);
  require(t != NULL || *why.text != '\0', "a reason");
  return t;
}

static void check_token(const token *t) {
  const token_limits *m = &t->most;
  require(*t->name != '\0' && strpbrk(t->name, ": \t\n\"") == NULL, "a name");
  require(t->secrets > 0 && t->secrets <= TOKEN_SECRETS, "secrets");
  require(m->jobs >= 0 && m->points > 0 && m->body_bytes >= 0 && m->data_bytes >= 0, "limits");
  require(m->job_bytes >= 0 && m->streams >= 0, "limits");
  require(m->seconds > 0 && m->rate > 0 && m->burst >= 1, "limits");
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static parameters set;
  const uint8_t *end = memchr(data, 0, size);
  if (size > LONGEST) return 0;
  const size_t file = end != NULL ? (size_t)(end - data) : size;
  tokens *t = read_bytes(data, file);
  char *field = end != NULL ? strndup((const char *)end + 1, size - file - 1) : strdup("");
  param_defaults(&set);
  (void)host_allows(HOST_LOOPBACK, &set, field);
  (void)host_lists(field, "https://a");
  if (t != NULL) {
    const token *found = credential_find(t, field);
    if (found != NULL) check_token(found);
    require(tokens_count(t) > 0, "a token");
    tokens_free(&t);
  }
  free(field);
  return 0;
}
