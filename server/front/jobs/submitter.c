#include "submitter.h"

#include "http.h"

void submitter_of(const exchange *x, char submitter[JOB_SUBMITTER]) {
  http_peer(x, submitter, JOB_SUBMITTER);
}
