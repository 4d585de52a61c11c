/* march_matrix.h - the matrix of a time step, factored: equation rows I + shift A, condition rows
 * A.
 *
 * It covers all unknowns (implicit schemes), or the condition rows only, among themselves (explicit
 * ones: there the equation rows are known when the conditions are imposed). */
#ifndef SCATTER_MARCH_MATRIX_H
#define SCATTER_MARCH_MATRIX_H

#include "scatter/assemble.h"
#include "scatter/solve.h"

typedef struct sct_march_matrix sct_march_matrix;

/* Chooses the rows; nothing is factored yet. SCT_E_MEMORY. */
SCT_NODISCARD sct_status sct_march_matrix_new(const sct_system *system, bool conditions_only,
                                              sct_march_matrix **matrix, sct_error *err);
void sct_march_matrix_free(sct_march_matrix **matrix);

/* Forms and factors the matrix; analyses the pattern where it is not that of the last time.
 * Statuses of sct_solver_analyse and sct_solver_factor. */
SCT_NODISCARD sct_status sct_march_matrix_factor(sct_march_matrix *matrix, const sct_system *system,
                                                 double shift, const sct_solve_options *options,
                                                 sct_error *err);

/* y [unknowns] from rhs [unknowns]: covered rows are solved, the others are y = rhs. y holds a
 * guess if all rows are covered. Statuses of sct_solver_solve. */
SCT_NODISCARD sct_status sct_march_matrix_solve(sct_march_matrix *matrix, const sct_system *system,
                                                const double *rhs, double *y, sct_error *err);

/* y [unknowns] = M^-T rhs, M being all rows: those of y = rhs, too. The same statuses. */
SCT_NODISCARD sct_status sct_march_matrix_solve_transposed(sct_march_matrix *matrix,
                                                           const sct_system *system,
                                                           const double *rhs, double *y,
                                                           sct_error *err);

/* NULL as long as nothing was factored. */
const sct_solve_report *sct_march_matrix_report(const sct_march_matrix *matrix);
int64_t sct_march_matrix_factorisations(const sct_march_matrix *matrix);

#endif
