#include "parallel.h"

/* A thread is worth its start for so many items. */
enum { WORTH = 512 };

static bool do_piece(int threads, int64_t first, int64_t length, sct_slice *slice, void *context) {
  bool ok = true;
  if (threads > 1 + length / WORTH) threads = (int)(1 + length / WORTH);
#ifdef _OPENMP
#pragma omp parallel for num_threads(threads) schedule(static, 1) reduction(&& : ok) if (threads > 1)
#endif
  for (int t = 0; t < threads; t++) {
    int64_t start = length * t / threads, end = length * (t + 1) / threads;
    ok = slice(context, first + start, first + end, t) && ok;
  }
  return ok;
}

sct_status sct_in_pieces(int64_t n, const sct_work *work, const char *phase, sct_slice *slice,
                         void *context, bool *complete, sct_error *err) {
  enum { PIECE = 1 << 17 };
  *complete = true;
  for (int64_t first = 0; first < n && *complete; first += PIECE) {
    int64_t length = n - first < PIECE ? n - first : PIECE;
    sct_status status = sct_work_report(work, phase, (double)first / (double)n, err);
    if (status != SCT_OK) return status;
    *complete = do_piece(sct_work_threads(work), first, length, slice, context);
  }
  return SCT_OK;
}
