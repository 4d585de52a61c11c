/* march.h - d phi / dt + A phi = b in time, Dirichlet values and condition rows carried along. */
#ifndef SCATTER_MARCH_H
#define SCATTER_MARCH_H

#include "scatter/assemble.h"
#include "scatter/limited.h"
#include "scatter/solve.h"

#ifdef __cplusplus
extern "C" {
#endif

/* With A, b of the equation rows of a system (b = load - coupling phi), a prime for the new time:
 * forward-euler   phi' = phi + dt (b - A phi); dt at most sct_march_stable_step
 * backward-euler  (I + dt A') phi' = phi + dt b'
 * crank-nicolson  (I + dt/2 A') phi' = (I - dt/2 A) phi + dt/2 (b + b')
 * bdf2            variable step; starts with one backward Euler step, and starts again after a step
 *                 more than twice as long as the one before
 * With upwind `limited` (a system that has one) A phi is A phi - q(phi) of limited.h: implicit
 * steps are solved by its iteration, from the old values, with the factors of the first-order part.
 * Condition rows hold at the new time in every scheme: as algebraic rows of the implicit ones, by a
 * solve among themselves after the equation rows in forward Euler. Schemes that use the rate at the
 * old time (forward Euler, Crank-Nicolson) do the same to the initial values for their first rate.
 */
#define SCT_MARCH_LIST(X)                 \
  X(SCT_FORWARD_EULER, "forward-euler")   \
  X(SCT_BACKWARD_EULER, "backward-euler") \
  X(SCT_CRANK_NICOLSON, "crank-nicolson") \
  X(SCT_BDF2, "bdf2")
#define SCT_MARCH_ENUM(symbol, name) symbol,
typedef enum { SCT_MARCH_LIST(SCT_MARCH_ENUM) SCT_MARCH_COUNT } sct_march_method;
#undef SCT_MARCH_ENUM
const char *sct_march_name(sct_march_method method); /* NULL for other values */
sct_march_method sct_march_find(const char *name);   /* SCT_MARCH_COUNT if there is none */

/* What sct_march_tangent and sct_march_adjoint need of a march that was (adjoint.h): the levels it
 * went through, and, if `keeps_values`, phi at each. Zeroed but for the two settings before it is
 * handed to a march; sct_tape_clear frees what that put there. A tape of more than most_bytes is
 * SCT_E_LIMIT before the first step, one of upwind `limited`, which
 * has no derivative, SCT_E_ARGUMENT. */
typedef struct {
  bool keeps_values;  /* needed where matrix entries depend on what is differentiated by */
  int64_t most_bytes; /* 0: any number */
  /* set by the march */
  int64_t n, levels, room; /* points; levels recorded, and planned */
  bool is_settled;         /* conditions were imposed on level 0 */
  double *t, *dt;          /* [room] time of a level, step that led to it (0: level 0) */
  double *phi;             /* [room][n]; NULL without values */
} sct_tape;
void sct_tape_clear(sct_tape *tape);

typedef struct {
  sct_march_method method;
  double start, end;       /* (time) start < end */
  double step;             /* (time) longest dt, or 0: from diffusion_number */
  double diffusion_number; /* C_D: dt = C_D times sct_march_stable_step of the start */
  const double *save;      /* [saves] strictly ascending times in [start, end] of snapshots */
  int64_t saves;
  int64_t max_steps;       /* more than this: SCT_E_LIMIT before the first step; 0: any number */
  sct_solve_options solve; /* of the step matrices */
  sct_limited_options limited; /* of the iteration in a step, upwind `limited` only */
  sct_tape *tape;              /* records the march; NULL: nothing is recorded */
} sct_march_options;

/* Which parts of a problem depend on time. */
enum { SCT_VARIES_MATRIX = 1, SCT_VARIES_LOAD = 2, SCT_VARIES_DIRICHLET = 4 };

/* The problem as the march sees it. */
typedef struct {
  int varies; /* SCT_VARIES_* */
  void *context;
  /* Brings *system and the Dirichlet values in phi [n] to time t; called only if something
   * varies, at the start and before anything at a new time is used. With SCT_VARIES_MATRIX it may
   * replace *system, by one of the same unknowns and kinds of rows; a pattern that stays is
   * analysed only once. */
  sct_status (*advance)(void *context, double t, sct_system **system, double *phi, sct_error *err);
  /* Is handed phi [n] at every save time, and at the end if that is none (may be NULL). */
  sct_status (*save)(void *context, double t, const double *phi, sct_error *err);
} sct_march_problem;

typedef struct {
  int64_t steps;
  double step;        /* (time) largest step taken */
  double stable_step; /* (time) least bound of forward Euler met; 0: not needed, not computed */
  int64_t factorisations;
  sct_solve_report solve;     /* of the last solve; zeroes if there was none */
  sct_limited_report limited; /* upwind `limited` only */
} sct_march_report;

/* Largest stable explicit step of the equation rows, by Gershgorin's discs,
 *   dt = min_i 2 / (A_ii + sum_(j != i) |A_ij|) = min_i 2 / (sum_j a_ij + k_i + sum_j |a_ij|)
 * over the columns of matrix and coupling; for ps this is [H16] eq. 39d, 44c, 48c with C_D = 1, the
 * minimum taken. `point` (may be NULL) gets the point that sets it, or -1. Infinity if no row
 * bounds it. With upwind `limited` each disc has sct_limited_reach more: a step that keeps the
 * bounds. Where all a_ij >= 0 this is sufficient and nearly necessary; it bounds real eigenvalues
 * only, so convection without upwinding beyond a cell Peclet number |u| h / mu of 2 is not stable
 * up to it (in one dimension it also needs dt <= 2 mu / u^2), which the march sees by growth. Cost
 * O(entries). Proof: unit.march */
double sct_march_stable_step(const sct_system *system, int64_t *point);

/* Marches phi [n], the initial values (Dirichlet points: theirs), in place from start to end;
 * `problem`, `work`, `report` may be NULL. The steps of forward Euler are equal but for the last
 * before each save time, which is shortened; implicit schemes divide each interval between save
 * times evenly, so that the factors serve the whole interval, and the next if its step is the same.
 * Progress is phase "march", told after each step. On failure phi holds the last values reached and
 * the report what was done so far.
 * SCT_E_ARGUMENT (times, step, scheme, a system that changed its size), SCT_E_LIMIT (steps),
 * SCT_E_MEMORY, SCT_E_CANCELLED, what the callbacks return;
 * SCT_E_NOT_FINITE (initial values, matrix, loads, Dirichlet values: with the point);
 * SCT_E_CONVERGENCE (upwind `limited`: a step whose iteration stagnates);
 * SCT_E_SINGULAR of the step matrix, or for forward Euler of the condition rows among themselves;
 * SCT_E_UNSTABLE if a forward Euler step exceeds the stable one (with the point and both steps), or
 * if |phi| exceeds 1e6 times what the data account for by the maximum principle - initial and
 * Dirichlet values, sources and fluxes summed over time, the exponential of a feeding reaction
 * (k < 0) or Robin coefficient (with the point, time and step) - or 1e280.
 * Cost per step: one product with the matrix (explicit), one solve (implicit), one factorisation
 * more if matrix or step changed. Proof: verify.march (orders 1, 1, 2, 2; exactness for polynomials
 * in t; Neumann and Robin rows; time-dependent loads, Dirichlet values, matrices), unit.march,
 * fault.solve */
SCT_NODISCARD sct_status sct_march(sct_system **system, const sct_march_options *options,
                                   const sct_march_problem *problem, const sct_work *work,
                                   double *phi, sct_march_report *report, sct_error *err);

#ifdef __cplusplus
}
#endif
#endif
