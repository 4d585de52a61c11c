/* petsc_calls.h - PETSc as it is used here: its functions by pointers, found when first asked for.
 *
 * Linked in, PETSc and the hundred libraries behind it would cost every start of a program 60 ms
 * and 30 MB; so libpetsc is loaded at the first iterative solve, for good. It runs without a
 * launcher, as an MPI of one process that starts no other, takes no signal, reads no file of
 * options and opens no connection; errors come back as codes.
 */
#ifndef SCATTER_PETSC_CALLS_H
#define SCATTER_PETSC_CALLS_H

#define OMPI_SKIP_MPICXX
#include <petscksp.h>

#include "scatter/status.h"

/* clang-format off */
#define PETSC_CALLS(X) \
  X(MPI_Allgatherv) \
  X(MPI_Allreduce) \
  X(MPI_Comm_rank) \
  X(MPI_Comm_size) \
  X(PetscFinalize) \
  X(PetscInitializeNoArguments) \
  X(PetscMallocSet) \
  X(PetscOptionsSetValue) \
  X(PetscPushErrorHandler) \
  X(MatCreateMPIAIJWithArrays) \
  X(MatCreateSeqAIJWithArrays) \
  X(MatDestroy) \
  X(MatMult) \
  X(VecCreateMPIWithArray) \
  X(VecCreateSeqWithArray) \
  X(VecDestroy) \
  X(VecPlaceArray) \
  X(VecResetArray) \
  X(KSPCreate) \
  X(KSPDestroy) \
  X(KSPSetOperators) \
  X(KSPSetType) \
  X(KSPSetPCSide) \
  X(KSPSetNormType) \
  X(KSPSetOptionsPrefix) \
  X(KSPSetFromOptions) \
  X(KSPSetInitialGuessNonzero) \
  X(KSPSetConvergenceTest) \
  X(KSPGetPC) \
  X(KSPSetUp) \
  X(KSPSolve) \
  X(KSPSolveTranspose) \
  X(KSPGetIterationNumber) \
  X(KSPGetConvergedReason) \
  X(PCSetType) \
  X(PCGetFailedReason)
/* clang-format on */

typedef struct {
#define PETSC_POINTER(name) __typeof__(name) *name;
  PETSC_CALLS(PETSC_POINTER)
#undef PETSC_POINTER
  MPI_Comm self, world; /* this process alone; all that a launcher started together */
  MPI_Datatype number;  /* double */
  MPI_Op sum, most;
} petsc_calls;

/* The functions, ready for use; NULL if PETSc is not there (SCT_E_ARGUMENT) or finds no memory
 * (SCT_E_MEMORY). What was found out at the first call holds for the process. */
const petsc_calls *petsc_open(sct_error *err);

/* Ends PETSc and MPI for good, together with all processes that share them. */
void petsc_close(void);

/* What PETSc said of its last error, for messages. */
const char *petsc_complaint(void);

/* PETSc cannot destroy what it had no memory to finish. So everything it allocates from petsc_own
 * on, on this thread, goes onto a list (NULL: none). petsc_abandon frees the arrays on it;
 * petsc_keep leaves to PETSc what is still on it when all objects are destroyed. */
typedef struct petsc_block petsc_block;
void petsc_own(petsc_block **list);
void petsc_abandon(petsc_block **list);
void petsc_keep(petsc_block **list);

/* Was there an allocation that failed since petsc_own? */
bool petsc_ran_out(void);

/* Multigrid by hypre, as option prefixes of a KSP. */
#define PETSC_AMG "scatter_amg_"
#define PETSC_AMG_AGGRESSIVE "scatter_amg_aggressive_"

#endif
