#include "submitter.h"

#include <stdio.h>

#include "http.h"

void submitter_of(const exchange *x, char submitter[JOB_SUBMITTER]) {
  if (*x->owner != '\0') {
    snprintf(submitter, JOB_SUBMITTER, "%s", x->owner);
  } else {
    http_peer(x, submitter, JOB_SUBMITTER);
  }
}
