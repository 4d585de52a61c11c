#include "answer_cases.h"

#include <stdlib.h>
#include <string.h>

bool answer_case_next(FILE *file, answer_case *c) {
  char line[ANSWER_CASE_LINE];
  c->title[0] = c->body[0] = '\0';
  while (fgets(line, sizeof line, file)) {
    if (line[0] == '#') snprintf(c->title, sizeof c->title, "%.*s", ANSWER_CASE_LINE - 1, line + 2);
    if (line[0] != '#' && line[0] != '\n') break;
  }
  if (feof(file)) return false;
  int used = 0;
  if (sscanf(line, "%63s %d %n", c->process, &c->status, &used) != 2) abort();
  snprintf(c->pointers, sizeof c->pointers, "%s", line + used);
  c->pointers[strcspn(c->pointers, "\n")] = '\0';
  while (fgets(line, sizeof line, file) && line[0] != '\n') {
    strncat(c->body, line, ANSWER_CASE_BODY - strlen(c->body) - 1);
  }
  return true;
}
