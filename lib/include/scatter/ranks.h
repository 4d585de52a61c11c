/* ranks.h - one steady system by many processes ("ranks"), which mpiexec or srun started together.
 *
 * Every rank has the whole problem; each assembles its part of the rows (partition.h) and iterates
 * with the others, by PETSc over MPI: BiCGStab, then GMRES, with blocks of ILU(0), one per rank, or
 * BoomerAMG, chosen as sequentially (solve_policy.h). All calls but sct_ranks_alone are collective,
 * and their statuses the same on all ranks, but for SCT_E_MEMORY: a rank that has met that must end
 * the program, for the others wait for it.
 */
#ifndef SCATTER_RANKS_H
#define SCATTER_RANKS_H

#include "scatter/partition.h"
#include "scatter/solve.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sct_ranks sct_ranks; /* opaque; one per process */

/* This process's place among those that a launcher started, from its environment (Open MPI, PMI,
 * Slurm); false if there was none, then 0 of 1. Starts nothing. */
bool sct_ranks_place(int *rank, int *count);

/* Leaves the others for good: what runs from now on is a program of one process. Before
 * sct_ranks_open. */
void sct_ranks_alone(void);

/* Starts MPI. SCT_E_ARGUMENT if the library was built without PETSc or it is not installed,
 * SCT_E_MEMORY. *ranks is NULL on failure. */
SCT_NODISCARD sct_status sct_ranks_open(sct_ranks **ranks, sct_error *err);

/* Ends MPI, when all ranks have come here. */
void sct_ranks_close(sct_ranks **ranks);

int sct_ranks_rank(const sct_ranks *ranks); /* 0 .. count - 1 */
int sct_ranks_count(const sct_ranks *ranks);

/* What the parts were. */
typedef struct {
  int64_t unknowns, nonzeros; /* of the whole */
  int64_t widened, fallback, loose;
  int64_t halo, halo_most;                   /* points in all halos; in the largest */
  int64_t own_most;                          /* points in the largest part */
  int rounds;                                /* most times that a part made its rows */
  double seconds_assemble, seconds_exchange; /* of this rank: rows; the gathering of the result */
} sct_ranks_report;

/* Solves: phi [n] in: values at Dirichlet points; out, on every rank: the solution. solve->residual
 * and the rest are those of the whole. Failures of assembly as sct_part_assemble, of the lowest
 * rank that has one; SCT_E_CONVERGENCE where no attempt met the tolerance, and for a right-hand
 * side or solution that is not finite. `work` hears of assembly and iteration (residuals).
 * Proof: verify.ranks (agreement with sct_solver_solve for 1, 2 and 4 ranks) */
SCT_NODISCARD sct_status sct_ranks_solve(sct_ranks *ranks, const sct_part_problem *problem,
                                         const sct_solve_options *options, const sct_work *work,
                                         double *phi, sct_solve_report *solve,
                                         sct_ranks_report *report, sct_error *err);

#ifdef __cplusplus
}
#endif
#endif
