/* parallel.h - the one OpenMP loop of the library, which is a plain loop where there is none.
 *
 * SCT_PARALLEL_FOR(threads, ok) stands before `for (int t = 0; t < threads; t++)` whose body
 * says `ok = part(t) && ok;` with a bool ok. Results must not depend on the number of threads:
 * each part writes memory of its own.
 */
#ifndef SCATTER_PARALLEL_H
#define SCATTER_PARALLEL_H

#ifdef _OPENMP
#define SCT_PRAGMA(text) _Pragma(#text)
#define SCT_PARALLEL_FOR(threads, ok) \
  SCT_PRAGMA(omp parallel for num_threads(threads) schedule(static, 1) reduction(&& : ok))
#else
#define SCT_PARALLEL_FOR(threads, ok)
#endif

#endif
