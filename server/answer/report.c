#include "report.h"

#include <sys/resource.h>

#include "member.h"

static int64_t memory_peak(void) {
  struct rusage usage = {0};
  getrusage(RUSAGE_SELF, &usage);
  return (int64_t)usage.ru_maxrss * 1024;
}

void report_write(emit *e, const task *t, const void *state) {
  stopwatch watch = t->watch;
  (void)state;
  stopwatch_lap(&watch, LAP_ENCODE);
  emit_object(e);
  member_text(e, "version", SCATTERD_VERSION);
  member_integer(e, "threads", sct_work_threads(&t->work));
  member_object(e, "seconds");
  for (int k = 0; k < LAP_COUNT; k++) member_number(e, lap_name((lap)k), watch.seconds[k]);
  member_number(e, "total", stopwatch_total(&watch));
  emit_end(e);
  member_integer(e, "memory_peak_bytes", memory_peak());
  emit_end(e);
}
