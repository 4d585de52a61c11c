/* march.h - d phi / dt + A phi = b in time, Dirichlet values and condition rows carried along. */
#ifndef SCATTER_MARCH_H
#define SCATTER_MARCH_H

#include "scatter/assemble.h"
#include "scatter/solve.h"

#ifdef __cplusplus
extern "C" {
#endif

/* forward-euler   phi' = phi + dt (s - A phi); dt at most C_D times the stable step
 * backward-euler  (I + dt A) phi' = phi + dt s'
 * crank-nicolson  (I + dt/2 A) phi' = (I - dt/2 A) phi + dt/2 (s + s')
 * bdf2            variable step, started with one backward Euler step
 * Condition rows hold at the new time in every scheme. */
#define SCT_MARCH_LIST(X)                 \
  X(SCT_FORWARD_EULER, "forward-euler")   \
  X(SCT_BACKWARD_EULER, "backward-euler") \
  X(SCT_CRANK_NICOLSON, "crank-nicolson") \
  X(SCT_BDF2, "bdf2")
#define SCT_MARCH_ENUM(symbol, name) symbol,
typedef enum { SCT_MARCH_LIST(SCT_MARCH_ENUM) SCT_MARCH_COUNT } sct_march_method;
#undef SCT_MARCH_ENUM
const char *sct_march_name(sct_march_method method);
sct_march_method sct_march_find(const char *name);

typedef struct {
  sct_march_method method;
  double start, end;       /* start < end */
  double step;             /* dt, or 0: from diffusion_number */
  double diffusion_number; /* C_D: dt = C_D times sct_march_stable_step */
  const double *save;      /* [saves] ascending times in [start, end] at which to hand out phi */
  int64_t saves;
  int64_t max_steps; /* more than this: SCT_E_LIMIT before the first step */
  sct_solve_options solve;
} sct_march_options;

/* Which parts of a problem depend on time. */
enum { SCT_VARIES_MATRIX = 1, SCT_VARIES_LOAD = 2, SCT_VARIES_DIRICHLET = 4 };

/* The problem as the march sees it. */
typedef struct {
  int varies; /* SCT_VARIES_* */
  void *context;
  /* Brings *system and the Dirichlet values in phi [n] to time t; called only if something
   * varies, before anything at time t is used. May replace *system if SCT_VARIES_MATRIX. */
  sct_status (*advance)(void *context, double t, sct_system **system, double *phi, sct_error *err);
  /* Is handed phi [n] at every save time and at the end (may be NULL). */
  sct_status (*save)(void *context, double t, const double *phi, sct_error *err);
} sct_march_problem;

typedef struct {
  int64_t steps;
  double step;        /* largest step taken */
  double stable_step; /* bound of forward Euler, 0 where not computed */
  int64_t factorisations;
  sct_solve_report solve; /* of the last implicit solve */
} sct_march_report;

/* Largest stable explicit step of the equation rows, min_i 2 / (sum_j a_ij + sum_j |a_ij|) with
 * k_i added to both sums; for ps this is [H16] eq. 39d, 44c, 48c with C_D = 1. `point` (may be
 * NULL) gets the point that sets it. Infinity if no row bounds it. Proof: unit.march */
double sct_march_stable_step(const sct_system *system, int64_t *point);

/* Marches phi [n] in place from start to end. The steps of forward Euler are equal but for the
 * last before each save time, which is shortened; implicit schemes divide each interval between
 * save times evenly, so that the factors serve the whole interval.
 * SCT_E_ARGUMENT, SCT_E_LIMIT (steps), SCT_E_SINGULAR, SCT_E_MEMORY, SCT_E_CANCELLED;
 * SCT_E_UNSTABLE if a forward Euler step exceeds the stable one (with the point and both steps) or
 * if |phi| grows beyond 1e6 times the data (with the time). Proof: verify.march (order 1, 1, 2, 2;
 * Neumann rows; time-dependent fields), unit.march */
SCT_NODISCARD sct_status sct_march(sct_system **system, const sct_march_options *options,
                                   const sct_march_problem *problem, const sct_work *work,
                                   double *phi, sct_march_report *report, sct_error *err);

#ifdef __cplusplus
}
#endif
#endif
