#include "quota.h"

bool quota_allows(const service *s, exchange *x, int64_t more) {
  if (x->most.jobs == INT64_MAX) return true;
  const int64_t has = jobs_of(s->jobs, x->owner) + pool_tasks_of(s->pool, x->owner);
  if (has + more <= x->most.jobs) return true;
  exchange_add(x, "Retry-After", "%d", jobs_retry_after(s->jobs));
  exchange_refuse(x, 429,
                  "%lld executions wait or run, %lld more would be above %lld (limit: jobs of the "
                  "token)",
                  (long long)has, (long long)more, (long long)x->most.jobs);
  return false;
}

int64_t quota_jobs(const service *s, const exchange *x) {
  if (x->most.jobs == INT64_MAX) return INT64_MAX;
  return x->most.jobs - pool_tasks_of(s->pool, x->owner);
}

void quota_refuse_late(const service *s, exchange *x) {
  exchange_add(x, "Retry-After", "%d", jobs_retry_after(s->jobs));
  exchange_refuse(x, 429,
                  "by way of another daemon the token got as many executions as it may have, %lld "
                  "(limit: jobs of the token)",
                  (long long)x->most.jobs);
}
