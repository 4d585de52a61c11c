#include "token.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <sys/stat.h>

#include "param.h"

struct tokens {
  token *all;
  int count;
};

const token_limits token_unlimited = {.jobs = INT64_MAX,
                                      .points = INT64_MAX,
                                      .body_bytes = INT64_MAX,
                                      .data_bytes = INT64_MAX,
                                      .job_bytes = INT64_MAX,
                                      .streams = INT64_MAX,
                                      .seconds = INFINITY,
                                      .rate = INFINITY,
                                      .burst = 0};

static const char blanks[] = " \t\r\n";
static const char label[] = "sha256:";

/* ---- A line ---- */

static const struct {
  const char *name;
  size_t offset;
  bool whole, bytes; /* an integer; with KiB and the like */
  double least, most;
} rows[] = {
    {"jobs", offsetof(token_limits, jobs), true, false, 0, 1e9},
    {"points", offsetof(token_limits, points), true, false, 1, 9e15},
    {"body-bytes", offsetof(token_limits, body_bytes), true, true, 0, 9e15},
    {"data-bytes", offsetof(token_limits, data_bytes), true, true, 0, 9e15},
    {"job-bytes", offsetof(token_limits, job_bytes), true, true, 0, 9e15},
    {"streams", offsetof(token_limits, streams), true, false, 0, 1e9},
    {"seconds", offsetof(token_limits, seconds), false, false, 0.01, 1e7},
    {"rate", offsetof(token_limits, rate), false, false, 1e-6, 1e9},
    {"burst", offsetof(token_limits, burst), false, false, 1, 1e9},
};

enum { ROWS = sizeof rows / sizeof *rows };

static bool set_limit(token_limits *most, int k, const char *text, fault *why) {
  const double value = param_number(text, rows[k].bytes);
  const bool good = value >= rows[k].least && value <= rows[k].most;
  if (!good || (rows[k].whole && value != floor(value))) {
    return fault_set(why, "%s: got \"%.40s\", needs %s from %g to %g", rows[k].name, text,
                     rows[k].whole ? "an integer" : "a number", rows[k].least, rows[k].most);
  }
  void *at = (char *)most + rows[k].offset;
  if (rows[k].whole) *(int64_t *)at = (int64_t)value;
  if (!rows[k].whole) *(double *)at = value;
  return true;
}

/* A word "name=value". */
static bool read_limit(token_limits *most, const char *word, fault *why) {
  const size_t length = strcspn(word, "=");
  for (int k = 0; k < ROWS && word[length] == '='; k++) {
    if (strlen(rows[k].name) != length || strncmp(word, rows[k].name, length) != 0) continue;
    return set_limit(most, k, word + length + 1, why);
  }
  return fault_set(why,
                   "got \"%.60s\", needs sha256:DIGEST or one of jobs, points, body-bytes, "
                   "data-bytes, job-bytes, streams, seconds, rate, burst with = and a number",
                   word);
}

static int hex(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

static bool read_digest(token *t, const char *text, fault *why) {
  if (t->secrets == TOKEN_SECRETS) {
    return fault_set(why, "got more than %d digests", TOKEN_SECRETS);
  }
  unsigned char *to = t->digest[t->secrets++];
  if (strlen(text) != DIGEST_TEXT - 1 || strspn(text, "0123456789abcdef") != DIGEST_TEXT - 1) {
    return fault_set(why, "got a digest of %zu characters, needs %d of 0-9 and a-f", strlen(text),
                     DIGEST_TEXT - 1);
  }
  for (int k = 0; k < DIGEST_BYTES; k++, text += 2) {
    to[k] = (unsigned char)(16 * hex(text[0]) + hex(text[1]));
  }
  return true;
}

/* Owners stand where addresses of clients stand without tokens, so no name may look like one. */
static bool read_name(token *t, const char *name, fault *why) {
  static const char allowed[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-";
  const size_t length = strlen(name);
  const bool good = isalpha((unsigned char)*name) && length < TOKEN_NAME &&
                    strspn(name, allowed) == length && strcmp(name, "local") != 0;
  if (!good) {
    return fault_set(why,
                     "name: got \"%.60s\", needs a letter and up to %d letters, digits, '.', '_', "
                     "'-', and not \"local\"",
                     name, TOKEN_NAME - 2);
  }
  memcpy(t->name, name, length + 1);
  return true;
}

static bool read_word(token *t, const char *word, fault *why) {
  const size_t length = strlen(label);
  if (strncmp(word, label, length) == 0) return read_digest(t, word + length, why);
  return read_limit(&t->most, word, why);
}

/* One token out of a line without its comment; the line is cut up. */
static bool read_token(token *t, char *line, fault *why) {
  char *rest = NULL;
  *t = (token){.most = token_unlimited};
  if (!read_name(t, strtok_r(line, blanks, &rest), why)) return false;
  for (const char *word; (word = strtok_r(NULL, blanks, &rest)) != NULL;) {
    if (!read_word(t, word, why)) return false;
  }
  if (t->secrets == 0) return fault_set(why, "%s: got no sha256:DIGEST", t->name);
  if (t->most.burst <= 0) t->most.burst = fmax(1, t->most.rate);
  return true;
}

/* ---- The file ---- */

/* Digests are compared, all of them and each as a whole: how long that takes tells nothing. */
static token *holder(tokens *t, const unsigned char digest[DIGEST_BYTES]) {
  token *found = NULL;
  for (int k = 0; k < t->count; k++) {
    for (int s = 0; s < t->all[k].secrets; s++) {
      if (digest_is(t->all[k].digest[s], digest)) found = &t->all[k];
    }
  }
  return found;
}

/* Adds a token whose name and secrets nobody has yet. */
static bool add(tokens *t, const token *made, fault *why) {
  if (tokens_named(t, made->name) != NULL) {
    return fault_set(why, "%s: got this name twice", made->name);
  }
  for (int k = 0; k < made->secrets; k++) {
    const token *other = holder(t, made->digest[k]);
    if (other != NULL) return fault_set(why, "%s: got the secret of %s", made->name, other->name);
  }
  token *all = realloc(t->all, (size_t)(t->count + 1) * sizeof *all);
  if (all == NULL) return fault_set(why, "out of memory");
  t->all = all;
  all[t->count++] = *made;
  return true;
}

static bool read_line(tokens *t, char *line, fault *why) {
  token made;
  line[strcspn(line, "#")] = '\0';
  if (line[strspn(line, blanks)] == '\0') return true;
  return read_token(&made, line, why) && add(t, &made, why);
}

static bool read_lines(tokens *t, FILE *file, const char *path, fault *why) {
  char *line = NULL;
  size_t room = 0;
  bool good = true;
  ssize_t length;
  for (int number = 1; good && (length = getline(&line, &room, file)) >= 0; number++) {
    fault inner;
    good = strlen(line) == (size_t)length || fault_set(&inner, "got a NUL");
    good = good && read_line(t, line, &inner);
    if (!good) fault_set(why, "tokens: %.200s:%d: %.280s", path, number, inner.text);
  }
  if (good && !feof(file)) good = fault_set(why, "tokens: %.200s: %s", path, strerror(errno));
  free(line);
  return good;
}

static bool check_mode(FILE *file, const char *path, bool *is_public, fault *why) {
  struct stat facts;
  if (fstat(fileno(file), &facts) != 0) {
    return fault_set(why, "tokens: %.200s: %s", path, strerror(errno));
  }
  *is_public = (facts.st_mode & S_IROTH) != 0;
  if ((facts.st_mode & (S_IWGRP | S_IWOTH)) == 0) return true;
  return fault_set(why, "tokens: %.200s may be written by others than its owner (mode %03o)", path,
                   (unsigned)facts.st_mode & 0777);
}

/* What was used stays used. */
static void keep_used(tokens *t, const tokens *old) {
  for (int k = 0; old != NULL && k < old->count; k++) {
    token *same = tokens_named(t, old->all[k].name);
    if (same == NULL) continue;
    same->bucket = old->all[k].bucket;
    same->kept = old->all[k].kept;
  }
}

tokens *tokens_read(const char *path, const tokens *old, bool *is_public, fault *why) {
  tokens *t = calloc(1, sizeof *t);
  FILE *file = fopen(path, "re");
  bool good = false;
  if (t == NULL || file == NULL) {
    fault_set(why, "tokens: cannot read %.200s: %s", path, strerror(errno));
    goto done;
  }
  good = check_mode(file, path, is_public, why) && read_lines(t, file, path, why);
  if (good && t->count == 0) good = fault_set(why, "tokens: %.200s has no token", path);
  if (good) keep_used(t, old);
done:
  if (file != NULL) fclose(file);
  if (!good) tokens_free(&t);
  return t;
}

void tokens_free(tokens **t) {
  if (*t == NULL) return;
  free((*t)->all);
  free(*t);
  *t = NULL;
}

int tokens_count(const tokens *t) {
  return t->count;
}

/* ---- Looking ---- */

token *tokens_named(tokens *t, const char *name) {
  for (int k = 0; k < t->count; k++) {
    if (strcmp(t->all[k].name, name) == 0) return &t->all[k];
  }
  return NULL;
}

token *tokens_holding(tokens *t, const char *secret) {
  unsigned char digest[DIGEST_BYTES];
  digest_bytes(secret, strlen(secret), digest);
  return holder(t, digest);
}

/* ---- Making ---- */

static bool make_secret(char secret[TOKEN_SECRET]) {
  unsigned char bytes[32];
  if (getrandom(bytes, sizeof bytes, 0) != (ssize_t)sizeof bytes) return false;
  int used = snprintf(secret, TOKEN_SECRET, "sct_");
  for (size_t k = 0; k < sizeof bytes; k++) {
    used += snprintf(secret + used, (size_t)(TOKEN_SECRET - used), "%02x", bytes[k]);
  }
  return true;
}

bool token_make(const char *name, int count, char **words, char secret[TOKEN_SECRET],
                char line[TOKEN_LINE], fault *why) {
  token t = {.most = token_unlimited};
  unsigned char digest[DIGEST_BYTES];
  if (!read_name(&t, name, why)) return false;
  if (!make_secret(secret)) return fault_set(why, "no random numbers: %s", strerror(errno));
  digest_bytes(secret, strlen(secret), digest);
  size_t used = (size_t)snprintf(line, TOKEN_LINE, "%s %s", name, label);
  for (int k = 0; k < DIGEST_BYTES; k++) {
    used += (size_t)snprintf(line + used, TOKEN_LINE - used, "%02x", digest[k]);
  }
  for (int k = 0; k < count; k++) {
    if (!read_limit(&t.most, words[k], why)) return false;
    used += (size_t)snprintf(line + used, TOKEN_LINE - used, " %s", words[k]);
    if (used >= TOKEN_LINE) return fault_set(why, "got too many words");
  }
  return true;
}

/* ---- Using ---- */

void token_narrow(const token_limits *most, limits *l) {
  if (most->body_bytes < l->body_bytes) l->body_bytes = most->body_bytes;
  if (most->points < l->points) l->points = most->points;
  l->seconds = fmin(l->seconds, most->seconds);
}
