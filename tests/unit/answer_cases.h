/* answer_cases.h - reads answer_cases.txt. */
#ifndef ANSWER_CASES_H
#define ANSWER_CASES_H

#include <stdbool.h>
#include <stdio.h>

enum { ANSWER_CASE_LINE = 4096, ANSWER_CASE_BODY = 1 << 16 };

typedef struct {
  char title[ANSWER_CASE_LINE], process[64], pointers[ANSWER_CASE_LINE], body[ANSWER_CASE_BODY];
  int status;
} answer_case;

/* Reads the next case; false at the end of the file. */
bool answer_case_next(FILE *file, answer_case *c);

#endif
