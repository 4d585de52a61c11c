/* Where parameters come from: the configuration file and the command line. */
#include <ctype.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "param.h"

/* ---- Configuration file ---- */

/* Cuts blanks at both ends, in place. */
static char *trimmed(char *text) {
  while (isspace((unsigned char)*text)) text++;
  char *end = text + strlen(text);
  while (end > text && isspace((unsigned char)end[-1])) end--;
  *end = '\0';
  return text;
}

static void cut_comment(char *line) {
  for (char *at = line; *at != '\0'; at++) {
    if (*at == '#' && (at == line || isspace((unsigned char)at[-1]))) {
      *at = '\0';
      return;
    }
  }
}

static bool read_line(parameters *p, char *line, fault *why) {
  cut_comment(line);
  char *name = trimmed(line);
  if (*name == '\0') return true;
  char *equals = strchr(name, '=');
  if (equals == NULL) return fault_set(why, "got \"%.100s\", needs name = value", name);
  *equals = '\0';
  return param_set(p, trimmed(name), trimmed(equals + 1), why);
}

bool param_read(parameters *p, const char *path, fault *why) {
  FILE *file = fopen(path, "re");
  if (file == NULL) return fault_set(why, "cannot read %.200s: %s", path, strerror(errno));
  bool good = true;
  char *line = NULL;
  size_t room = 0;
  for (int number_of_line = 1; good && getline(&line, &room, file) >= 0; number_of_line++) {
    fault inner;
    good = read_line(p, line, &inner);
    if (!good) fault_set(why, "%.200s:%d: %.280s", path, number_of_line, inner.text);
  }
  if (good && !feof(file)) good = fault_set(why, "cannot read %.200s: %s", path, strerror(errno));
  free(line);
  fclose(file);
  return good;
}

/* ---- Command line ---- */

/* Is argv[*k] option `name`? Then *value is its value and *k stands on the last word used. */
static bool option(int count, char **argv, int *k, char *name, size_t size, const char **value) {
  const char *word = argv[*k];
  if (strncmp(word, "--", 2) != 0 || word[2] == '\0') return false;
  const size_t length = strcspn(word + 2, "=");
  snprintf(name, size, "%.*s", (int)length, word + 2);
  *value = word[2 + length] == '=' ? word + 3 + length : NULL;
  if (*value == NULL && *k + 1 < count) *value = argv[++*k];
  return true;
}

/* Applies the options of argv; `config` says which half: the configuration file or all others. */
static bool apply(parameters *p, bool config, int count, char **argv, int *kept, fault *why) {
  char name[64];
  const char *value;
  bool literal = false;
  *kept = 0;
  for (int k = 0; k < count; k++) {
    const int at = k;
    if (!literal && strcmp(argv[k], "--") == 0) {
      literal = true;
    } else if (literal || !option(count, argv, &k, name, sizeof name, &value)) {
      if (!config) argv[*kept] = argv[at];
      ++*kept;
    } else if (value == NULL) {
      return fault_set(why, "--%s: got no value", name);
    } else if (strcmp(name, "config") == 0) {
      if (config && !param_read(p, value, why)) return false;
    } else if (!config && !param_set(p, name, value, why)) {
      return false;
    }
  }
  return true;
}

bool param_take(parameters *p, int *count, char **argv, fault *why) {
  int kept;
  if (!apply(p, true, *count, argv, &kept, why)) return false;
  if (!apply(p, false, *count, argv, &kept, why)) return false;
  *count = kept;
  return true;
}
