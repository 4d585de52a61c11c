#include "report.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include "by_ranks.h"
#include "member.h"

/* Of this request, once report_begin has put the mark back. */
static int64_t memory_peak(void) {
  struct rusage usage = {0};
  getrusage(RUSAGE_SELF, &usage);
  return (int64_t)usage.ru_maxrss * 1024;
}

void report_begin(void) {
  static const char mark[] = "5"; /* proc(5): the peak of the resident set starts over */
  const int fd = open("/proc/self/clear_refs", O_WRONLY | O_CLOEXEC);
  if (fd < 0) return;
  (void)!write(fd, mark, sizeof mark - 1);
  close(fd);
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
  by_ranks_write(e, t);
  member_integer(e, "memory_estimate_bytes", t->memory_estimate);
  member_integer(e, "memory_peak_bytes", memory_peak());
  emit_end(e);
}
