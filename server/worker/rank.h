/* rank.h - one of the processes that answer a request together, started by mpiexec.
 *
 * It has no socket to the front, but the directory of the run (run_dir.h). It is not sandboxed as
 * workers are, for MPI needs files, sockets and shared memory: it runs with the rights of the
 * daemon's user, limited in memory (memory-bytes each), with a request that a sandboxed worker has
 * decoded and checked before.
 */
#ifndef SCATTERD_RANK_H
#define SCATTERD_RANK_H

/* `scatterd rank DIRECTORY`. Returns the exit status: not 0 if the others are to be ended. */
int rank_main(const char *directory);

#endif
