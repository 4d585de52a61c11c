/* PETSc gets the rows of a part in the order of their numbers in the whole, scaled as for one
 * process, with given values gone to the right-hand side. The solution comes back by an allgather,
 * for every rank holds whole fields anyway. */
#include "scatter/ranks.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "alloc.h"
#include "petsc_krylov.h"
#include "seconds.h"
#include "solve_matrix.h"

struct sct_ranks {
  const petsc_calls *petsc;
  int rank, count;
};

/* The rows of this rank as PETSc sees them. */
typedef struct {
  krylov by;
  const sct_part_system *part;
  int *start, *column;  /* [rows + 1], [nonzeros] numbers in the whole */
  double *value;        /* [nonzeros] of D A */
  double *scale;        /* [rows] D */
  double *rhs, *x, *ax; /* [rows] D b, x, D A x */
  int32_t *row_at;      /* [rows] row of part->system with number first + r */
  Vec product;
} shared;

/* ---- ranks ---- */

sct_status sct_ranks_open(sct_ranks **out, sct_error *err) {
  sct_ranks *r = NULL;
  *out = NULL;
  const petsc_calls *petsc = petsc_open(err);
  if (petsc == NULL) return err != NULL ? err->code : SCT_E_ARGUMENT;
  sct_status status = sct_alloc_zero(&r, 1, sizeof *r, err);
  if (status != SCT_OK) return status;
  r->petsc = petsc;
  (void)petsc->MPI_Comm_rank(petsc->world, &r->rank);
  (void)petsc->MPI_Comm_size(petsc->world, &r->count);
  *out = r;
  return SCT_OK;
}

void sct_ranks_close(sct_ranks **ranks) {
  if (*ranks == NULL) return;
  sct_release(ranks);
  petsc_close();
}

int sct_ranks_rank(const sct_ranks *ranks) {
  return ranks->rank;
}

int sct_ranks_count(const sct_ranks *ranks) {
  return ranks->count;
}

static void reduce(const sct_ranks *r, MPI_Op op, double *values, int n) {
  double mine[16];
  memcpy(mine, values, (size_t)n * sizeof *values);
  (void)(r->petsc->MPI_Allreduce)(mine, values, n, r->petsc->number, op, r->petsc->world);
}

/* All ranks go on, or none: with the failure of the lowest rank that has one, in its own words
 * there, in these elsewhere. */
static sct_status agree(const sct_ranks *r, sct_status mine, const sct_error *why, sct_error *err) {
  double first[1] = {mine == SCT_OK ? -(double)r->count : -(double)r->rank}; /* - lowest rank */
  reduce(r, r->petsc->most, first, 1);
  const int lowest = (int)-first[0];
  double code[1] = {r->rank == lowest ? (double)mine : 0};
  if (lowest == r->count) return SCT_OK;
  reduce(r, r->petsc->most, code, 1);
  if (r->rank == lowest) {
    if (err != NULL) *err = *why;
    return mine;
  }
  return sct_fail(err, (sct_status)code[0], -1, "fails in part %d", lowest);
}

/* ---- rows ---- */

static double value_of(const sct_csr *a, int64_t row, int64_t column) {
  for (int64_t k = a->start[row]; k < a->start[row + 1]; k++) {
    if (a->column[k] == column) return a->value[k];
  }
  return 0;
}

static double largest(const sct_csr *a, int64_t row, double most) {
  for (int64_t k = a->start[row]; k < a->start[row + 1]; k++) most = fmax(most, fabs(a->value[k]));
  return most;
}

/* Adds an entry to a row in the making, which stays ascending. */
static void insert(int *column, double *value, int64_t n, int number, double v) {
  int64_t at = n;
  for (; at > 0 && column[at - 1] > number; at--) {
    column[at] = column[at - 1];
    value[at] = value[at - 1];
  }
  column[at] = number;
  value[at] = v;
}

/* Row r of the part: own unknowns from the matrix, those of the halo from the coupling. */
static void fill_row(shared *s, int64_t r) {
  const sct_system *system = s->part->system;
  const int32_t row = s->row_at[r];
  const sct_csr *own = system->matrix, *others = system->coupling;
  int64_t n = s->start[r];
  int *const column = s->column + n;
  double *const value = s->value + n;
  n = 0;
  for (int64_t k = own->start[row]; k < own->start[row + 1]; k++) {
    const int number = s->part->number[system->point_of[own->column[k]]];
    insert(column, value, n++, number, s->scale[r] * own->value[k]);
  }
  for (int64_t k = others->start[row]; k < others->start[row + 1]; k++) {
    const int number = s->part->number[others->column[k]];
    if (number >= 0) insert(column, value, n++, number, s->scale[r] * others->value[k]);
  }
  s->start[r + 1] = s->start[r] + (int)n;
}

static sct_status fill(shared *s, sct_error *err) {
  const sct_system *system = s->part->system;
  for (int64_t row = 0; row < s->by.rows; row++) {
    s->row_at[s->part->number[system->point_of[row]] - s->part->first] = (int32_t)row;
  }
  for (int64_t r = 0; r < s->by.rows; r++) {
    // NOLINTNEXTLINE(clang-analyzer-core.NullDereference): a failure is never SCT_OK
    const int32_t row = s->row_at[r];
    const double most = largest(system->coupling, row, largest(system->matrix, row, 0));
    if (!(most >= DBL_MIN && isfinite(most))) {
      return sct_fail(err, SCT_E_SINGULAR, s->part->part->point[system->point_of[row]],
                      "has a row of zeroes, or one that is not finite");
    }
    s->scale[r] =
        sct_solve_scale(most, value_of(system->matrix, row, row), system->is_equation[row] != 0);
    fill_row(s, r);
  }
  return SCT_OK;
}

static sct_status take(shared *s, sct_error *err) {
  const sct_system *system = s->part->system;
  const int64_t rows = s->by.rows;
  const int64_t most =
      rows == 0 ? 0 : sct_csr_entries(system->matrix) + sct_csr_entries(system->coupling);
  if (most > INT32_MAX) {
    return sct_fail(err, SCT_E_LIMIT, -1, "a part has more than 2^31 entries; take more ranks");
  }
  sct_status status = sct_alloc_zero(&s->start, rows + 1, sizeof *s->start, err);
  if (status == SCT_OK) status = sct_alloc(&s->column, most, sizeof *s->column, err);
  if (status == SCT_OK) status = sct_alloc(&s->value, most, sizeof *s->value, err);
  if (status == SCT_OK) status = sct_alloc(&s->scale, rows, sizeof *s->scale, err);
  if (status == SCT_OK) status = sct_alloc(&s->rhs, rows, sizeof *s->rhs, err);
  if (status == SCT_OK) status = sct_alloc_zero(&s->x, rows, sizeof *s->x, err);
  if (status == SCT_OK) status = sct_alloc(&s->ax, rows, sizeof *s->ax, err);
  if (status == SCT_OK) status = sct_alloc(&s->row_at, rows, sizeof *s->row_at, err);
  return status;
}

/* D b, with the values of halo unknowns left to the matrix. */
static void fill_rhs(shared *s, const double *phi) {
  const sct_system *system = s->part->system;
  const sct_part *part = s->part->part;
  for (int64_t r = 0; r < s->by.rows; r++) {
    const int32_t row = s->row_at[r];
    double b = system->load[row];
    for (int64_t k = system->coupling->start[row]; k < system->coupling->start[row + 1]; k++) {
      const int32_t point = system->coupling->column[k];
      if (s->part->number[point] < 0) b -= system->coupling->value[k] * phi[part->point[point]];
    }
    s->rhs[r] = s->scale[r] * b;
  }
}

static void release(shared *s) {
  const bool is_abandoned = s->by.matrix == NULL; /* with all that was made beside it */
  if (s->product != NULL && !is_abandoned) (void)s->by.petsc->VecDestroy(&s->product);
  krylov_drop(&s->by);
  petsc_keep(&s->by.blocks);
  sct_release(&s->start);
  sct_release(&s->column);
  sct_release(&s->value);
  sct_release(&s->scale);
  sct_release(&s->rhs);
  sct_release(&s->x);
  sct_release(&s->ax);
  sct_release(&s->row_at);
}

/* ---- the solve ---- */

/* |D (b - A x)|^2 of the rows of this rank */
static double residual(void *of, bool transposed, const double *b, const double *x) {
  shared *s = of;
  const petsc_calls *p = s->by.petsc;
  double sum = 0;
  (void)transposed;
  PetscErrorCode code = p->VecPlaceArray(s->by.x, x);
  if (code == 0) code = p->MatMult(s->by.matrix, s->by.x, s->product);
  (void)p->VecResetArray(s->by.x);
  if (code != 0) return INFINITY;
  for (int64_t r = 0; r < s->by.rows; r++) sum += (b[r] - s->ax[r]) * (b[r] - s->ax[r]);
  return sum;
}

/* Means over the rows of all ranks; the halo's part of a row does not count. */
static void find_traits(const sct_ranks *ranks, shared *s) {
  double sums[3] = {0};
  if (s->by.rows > 0) {
    const sct_solve_traits mine = sct_solve_traits_of(s->part->system->matrix, s->by.options.dim);
    sums[0] = (double)mine.rows;
    sums[1] = mine.dominance * (double)mine.rows;
    sums[2] = mine.skewness * (double)mine.rows;
  }
  reduce(ranks, ranks->petsc->sum, sums, 3);
  s->by.traits = (sct_solve_traits){.dim = s->by.options.dim,
                                    .rows = (int64_t)sums[0],
                                    .dominance = sums[1] / sums[0],
                                    .skewness = sums[2] / sums[0]};
}

static PetscErrorCode make_objects(shared *s) {
  krylov *k = &s->by;
  const petsc_calls *p = k->petsc;
  const int rows = (int)k->rows;
  PetscErrorCode code =
      p->MatCreateMPIAIJWithArrays(p->world, rows, rows, PETSC_DETERMINE, PETSC_DETERMINE, s->start,
                                   s->column, s->value, &k->matrix);
  if (code == 0) {
    code = p->VecCreateMPIWithArray(p->world, 1, rows, PETSC_DETERMINE, NULL, &k->rhs);
  }
  if (code == 0) code = p->VecCreateMPIWithArray(p->world, 1, rows, PETSC_DETERMINE, NULL, &k->x);
  if (code == 0) {
    code = p->VecCreateMPIWithArray(p->world, 1, rows, PETSC_DETERMINE, s->ax, &s->product);
  }
  return code;
}

static sct_status iterate(const sct_ranks *ranks, shared *s, sct_solve_report *report,
                          sct_error *err) {
  krylov *k = &s->by;
  const double begin = seconds_now();
  find_traits(ranks, s);
  k->preconditioner = krylov_first(k);
  petsc_own(&k->blocks);
  const PetscErrorCode code = make_objects(s);
  sct_status status =
      code == 0 ? krylov_set_up(k, report, err) : krylov_failed(k, code, "matrix", err);
  petsc_own(NULL);
  report->seconds_factor = seconds_now() - begin;
  if (status == SCT_OK) status = krylov_solve(k, s->rhs, false, s->x, report, err);
  report->seconds_solve = seconds_now() - begin - report->seconds_factor;
  return status;
}

/* Puts the unknowns of all ranks into phi. */
static sct_status gather(const sct_ranks *ranks, const shared *s, const sct_part_problem *problem,
                         double *phi, sct_error *err) {
  const petsc_calls *p = ranks->petsc;
  const sct_partition *partition = problem->partition;
  const uint8_t *condition = problem->boundary->condition;
  int *counts = NULL, *starts = NULL;
  double *all = NULL;
  sct_status status = sct_alloc_zero(&counts, ranks->count, sizeof *counts, err);
  if (status == SCT_OK) status = sct_alloc_zero(&starts, ranks->count + 1, sizeof *starts, err);
  if (status == SCT_OK) status = sct_alloc(&all, s->part->unknowns, sizeof *all, err);
  if (status != SCT_OK) goto done;
  for (int k = 0; k < ranks->count; k++) {
    for (int64_t place = sct_partition_start(partition, k);
         place < sct_partition_start(partition, k + 1); place++) {
      counts[k] += condition[sct_partition_point(partition, place)] != SCT_DIRICHLET;
    }
    starts[k + 1] = starts[k] + counts[k];
  }
  (void)(p->MPI_Allgatherv)(s->x, (int)s->by.rows, p->number, all, counts, starts, p->number,
                            p->world);
  for (int64_t place = 0, u = 0; place < problem->cloud->n; place++) {
    const int32_t point = sct_partition_point(partition, place);
    if (condition[point] != SCT_DIRICHLET) phi[point] = all[u++];
  }
done:
  sct_release(&counts);
  sct_release(&starts);
  sct_release(&all);
  return status;
}

/* ---- what there is to tell ---- */

/* max |b - A x|_i / (|b| + |A| |x|)_i of the rows of this rank */
static double backward_error(const shared *s, const double *phi) {
  const sct_system *system = s->part->system;
  const sct_part *part = s->part->part;
  double worst = 0;
  for (int64_t row = 0; row < s->by.rows; row++) {
    // NOLINTNEXTLINE(clang-analyzer-core.NullDereference): a failure is never SCT_OK
    double r = system->load[row], scale = fabs(r);
    for (int64_t k = system->matrix->start[row]; k < system->matrix->start[row + 1]; k++) {
      const int32_t point = system->point_of[system->matrix->column[k]];
      const double term = system->matrix->value[k] * phi[part->point[point]];
      r -= term;
      scale += fabs(term);
    }
    for (int64_t k = system->coupling->start[row]; k < system->coupling->start[row + 1]; k++) {
      const double term =
          system->coupling->value[k] * phi[part->point[system->coupling->column[k]]];
      r -= term;
      scale += fabs(term);
    }
    if (r != 0) worst = fmax(worst, fabs(r) / scale);
    if (!isfinite(r)) worst = INFINITY;
  }
  return worst;
}

static void tell(const sct_ranks *ranks, const shared *s, const double *phi,
                 sct_solve_report *solve, sct_ranks_report *report) {
  const sct_part *part = s->part->part;
  const sct_system *system = s->part->system;
  const double halo = (double)(part->n - part->own);
  double sums[] = {(double)s->by.nonzeros, halo, system ? (double)system->widened : 0,
                   system ? (double)system->fallback : 0, system ? (double)system->loose : 0};
  double most[] = {halo, (double)part->own, s->part->rounds, backward_error(s, phi)};
  reduce(ranks, ranks->petsc->sum, sums, sizeof sums / sizeof *sums);
  reduce(ranks, ranks->petsc->most, most, sizeof most / sizeof *most);
  report->unknowns = solve->rows = s->part->unknowns;
  report->nonzeros = solve->nonzeros = (int64_t)sums[0];
  report->halo = (int64_t)sums[1];
  report->widened = (int64_t)sums[2];
  report->fallback = (int64_t)sums[3];
  report->loose = (int64_t)sums[4];
  report->halo_most = (int64_t)most[0];
  report->own_most = (int64_t)most[1];
  report->rounds = (int)most[2];
  solve->residual = most[3];
  solve->method = "iterative";
  if (solve->factor_nonzeros > 0) solve->factor_nonzeros = report->nonzeros;
}

/* ---- the whole ---- */

static sct_status solve_shared(const sct_ranks *ranks, shared *s, const sct_part_problem *problem,
                               double *phi, sct_solve_report *solve, sct_ranks_report *report,
                               sct_error *err) {
  sct_error why = {.code = SCT_OK};
  sct_status status = take(s, err);
  if (status == SCT_E_MEMORY) return status;
  if (status == SCT_OK) status = fill(s, &why);
  status = agree(ranks, status, &why, err);
  if (status != SCT_OK) return status;
  // NOLINTNEXTLINE(clang-analyzer-core.NullDereference): a failure is never SCT_OK
  s->by.nonzeros = s->start[s->by.rows];
  fill_rhs(s, phi);
  status = iterate(ranks, s, solve, err);
  if (status != SCT_OK) return status;
  const double begin = seconds_now();
  status = gather(ranks, s, problem, phi, err);
  if (status != SCT_OK) return status;
  tell(ranks, s, phi, solve, report);
  report->seconds_exchange = seconds_now() - begin;
  if (isfinite(solve->residual)) return SCT_OK;
  return sct_fail(err, SCT_E_CONVERGENCE, -1, "the solution is not finite");
}

sct_status sct_ranks_solve(sct_ranks *ranks, const sct_part_problem *problem,
                           const sct_solve_options *options, const sct_work *work, double *phi,
                           sct_solve_report *solve, sct_ranks_report *report, sct_error *err) {
  sct_part_system *part = NULL;
  sct_error why = {.code = SCT_OK};
  const double begin = seconds_now();
  *solve = (sct_solve_report){0};
  *report = (sct_ranks_report){0};
  sct_status status = sct_part_assemble(problem, ranks->rank, work, &part, &why);
  report->seconds_assemble = seconds_now() - begin;
  if (status == SCT_E_MEMORY) {
    if (err != NULL) *err = why;
    return status;
  }
  status = agree(ranks, status, &why, err);
  if (status == SCT_OK) {
    shared s = {.by = {.petsc = ranks->petsc,
                       .is_shared = true,
                       .options = *options,
                       .rows = part->system != NULL ? part->system->unknowns : 0,
                       .blocks_count = ranks->count,
                       .residual = residual},
                .part = part};
    s.by.of = &s;
    s.by.options.work = work;
    status = solve_shared(ranks, &s, problem, phi, solve, report, err);
    release(&s);
  }
  sct_part_system_free(&part);
  return status;
}
