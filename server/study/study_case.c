#include "study_case.h"

#include "document.h"

void study_case_names(const char *names[STUDY_CASES_MAX + 1]) {
  int n = 0;
  while (n < STUDY_CASES_MAX && n < (int)study_document_count) {
    names[n] = study_documents[n].name;
    n++;
  }
  names[n] = NULL;
}

const doc *study_case_open(int k, doc_arena **arena) {
  static const doc_limits most = {32, 1 << 20, 1 << 20};
  const document *text = &study_documents[k];
  doc_error error;
  return doc_from_json(text->bytes, text->size, &most, arena, &error);
}
