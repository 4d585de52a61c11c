#include "scatter/assemble.h"

#include <math.h>
#include <string.h>

#include "alloc.h"
#include "assemble_part.h"
#include "length.h"
#include "limited_rows.h"
#include "points.h"
#include "row.h"
#include "row_buffer.h"

/* Points handled between two appends to the system: bounds the memory of rows in the making. */
enum { CHUNK_BLOCKS = 256, CHUNK = CHUNK_BLOCKS * SCT_POINTS_BLOCK };

typedef struct {
  const sct_stencil *stencil;
  const sct_fields *fields;
  const sct_boundary *boundary;
  bool diffuses;       /* some diffusivity is positive */
  int64_t chunk_first; /* first point of the chunk */
  int64_t blocks;      /* of a chunk: no more than the cloud has */
  row_buffer *buffers; /* [blocks] */
  uint8_t *flags;      /* [n] of the row of each point */
  sct_system *system;
  int64_t matrix_capacity, coupling_capacity;
} assembly;

static int dim_of(const assembly *job) {
  return sct_stencil_cloud(job->stencil)->dim;
}

/* ---- rows ---- */

/* k_ij = u . g_ij, in place of the first component */
static const double *contract(const sct_row *row, int dim, const double *u) {
  double *k_ij = row->gradient;
  for (int64_t k = 0; k < row->n; k++) {
    k_ij[k] *= u[0];
    for (int a = 1; a < dim; a++) k_ij[k] += u[a] * row->gradient[a * row->n + k];
  }
  return k_ij;
}

/* a_ij = a_ij - k_ij; of a limited system the upwind half of every edge */
static void convect(int64_t n, const double *k_ij, bool limited, double *a_ij) {
  for (int64_t k = 0; k < n; k++) a_ij[k] -= limited ? 2 * fmin(k_ij[k], 0) : k_ij[k];
}

static row_buffer *buffer_of(const assembly *job, int64_t i) {
  return &job->buffers[(i - job->chunk_first) / SCT_POINTS_BLOCK];
}

/* a_ij = (mu_i + mu_j)/2 l_ij - u_i . g_ij, in place of l_ij                       header, (2) */
static sct_status equation_row(assembly *job, int64_t i, sct_room *room, sct_error *err) {
  const sct_fields *fields = job->fields;
  const int dim = dim_of(job);
  const double *u = fields->velocity == NULL ? NULL : fields->velocity + i * dim;
  const double *mu = fields->diffusivity;
  bool moves = false;
  for (int a = 0; u != NULL && a < dim; a++) moves = moves || u[a] != 0;
  const int want =
      (moves ? SCT_ROW_GRADIENT : 0) | (job->diffuses ? SCT_ROW_LAPLACIAN | SCT_ROW_SOLVE : 0);
  sct_row row = {.n = 0};
  if (want != 0) {
    const sct_row_request request = {want, moves ? u : NULL, mu[i], NULL};
    const sct_status status = sct_stencil_row(job->stencil, i, &request, room, &row, err);
    if (status != SCT_OK) return status;
    job->flags[i] = (uint8_t)row.flags;
  }
  double *a_ij = room->laplacian;
  for (int64_t k = 0; k < row.n; k++) {
    a_ij[k] = job->diffuses ? 0.5 * (mu[i] + mu[row.index[k]]) * a_ij[k] : 0;
  }
  sct_limited *limited = job->system->limited;
  const double *k_ij = moves ? contract(&row, dim, u) : NULL;
  if (limited != NULL) {
    const sct_status status = sct_limited_add_edges(limited, i, row.n, row.index, k_ij, a_ij, err);
    if (status != SCT_OK) return status;
  }
  if (moves) convect(row.n, k_ij, limited != NULL, a_ij);
  const double k = fields->reaction == NULL ? 0 : fields->reaction[i];
  return row_buffer_append(buffer_of(job, i), i, row_sum(row.n, a_ij) + k, row.n, row.index, a_ij,
                           err);
}

static sct_status unit_normal(const double *normal, int dim, int64_t i, double *unit,
                              sct_error *err) {
  double largest = 0, scaled[SCT_DIM_MAX];
  for (int a = 0; a < dim; a++) largest = fmax(largest, fabs(normal[a]));
  const double scale = sct_scale_of(largest);
  for (int a = 0; a < dim; a++) scaled[a] = scale * normal[a];
  const double length = sct_length(scaled, dim);
  if (!(length > 0 && isfinite(length))) { /* nor of one that is no number anywhere */
    return sct_fail(err, SCT_E_ARGUMENT, i,
                    "has a condition on its normal derivative and no normal");
  }
  for (int a = 0; a < dim; a++) unit[a] = scaled[a] / length;
  return SCT_OK;
}

/* c phi_i + sum_j n . g_ij (phi_j - phi_i) */
static sct_status condition_row(assembly *job, int64_t i, sct_room *room, sct_error *err) {
  const sct_boundary *boundary = job->boundary;
  const int dim = dim_of(job);
  double normal[SCT_DIM_MAX];
  sct_row row;
  sct_status status = unit_normal(boundary->normal + i * dim, dim, i, normal, err);
  if (status != SCT_OK) return status;
  const sct_row_request request = {.want = SCT_ROW_NORMAL, .normal = normal};
  status = sct_stencil_row(job->stencil, i, &request, room, &row, err);
  if (status != SCT_OK) return status;
  job->flags[i] = (uint8_t)row.flags;
  for (int64_t k = 0; k < row.n; k++) row.normal[k] = -row.normal[k];
  if (job->system->limited != NULL) {
    status =
        sct_limited_add_edges(job->system->limited, i, row.n, row.index, NULL, row.normal, err);
    if (status != SCT_OK) return status;
  }
  const double c = boundary->condition[i] == SCT_ROBIN ? boundary->coefficient[i] : 0;
  return row_buffer_append(buffer_of(job, i), i, row_sum(row.n, row.normal) + c, row.n, row.index,
                           row.normal, err);
}

static sct_status row_of_point(assembly *job, int64_t i, sct_room *room, sct_error *err) {
  sct_limited *limited = job->system->limited;
  switch ((sct_condition)job->boundary->condition[i]) {
    case SCT_DIRICHLET:
      return limited == NULL ? SCT_OK : sct_limited_add_edges(limited, i, 0, NULL, NULL, NULL, err);
    case SCT_INTERIOR:
      return equation_row(job, i, room, err);
    default:
      return condition_row(job, i, room, err);
  }
}

static sct_status assemble_point(void *context, int64_t i, sct_room *room, sct_error *err) {
  assembly *job = context;
  const sct_status status = row_of_point(job, i, room, err);
  if (status != SCT_OK || job->system->limited == NULL) return status;
  return sct_limited_add_gradient(job->system->limited, job->stencil, i,
                                  (sct_condition)job->boundary->condition[i], room, err);
}

/* ---- the system ---- */

static sct_status csr_reserve(sct_csr *matrix, int64_t needed, int64_t *capacity, sct_error *err) {
  if (needed <= *capacity) return SCT_OK;
  const int64_t more = needed + needed / 2;
  sct_status status = sct_realloc(&matrix->column, more, sizeof *matrix->column, err);
  if (status == SCT_OK) status = sct_realloc(&matrix->value, more, sizeof *matrix->value, err);
  if (status == SCT_OK) *capacity = more;
  return status;
}

static void csr_push(sct_csr *matrix, int64_t *end, int32_t column, double value) {
  matrix->column[*end] = column;
  matrix->value[(*end)++] = value;
}

/* Splits the rows of a block into unknown and Dirichlet columns, behind what is there. Numbering
 * unknowns in the order of points keeps columns ascending. */
static sct_status append_block(assembly *job, const row_buffer *buffer, int64_t *next_row,
                               sct_error *err) {
  sct_system *system = job->system;
  int64_t end = system->matrix->start[*next_row], coupled = system->coupling->start[*next_row];
  sct_status status =
      csr_reserve(system->matrix, end + buffer->entries, &job->matrix_capacity, err);
  if (status == SCT_OK) {
    status = csr_reserve(system->coupling, coupled + buffer->entries, &job->coupling_capacity, err);
  }
  if (status != SCT_OK) return status;
  for (int64_t row = 0, e = 0; row < buffer->rows; row++) {
    for (int64_t stop = e + buffer->length[row]; e < stop; e++) {
      const int32_t point = buffer->column[e], unknown = system->row_of[point];
      if (unknown >= 0) csr_push(system->matrix, &end, unknown, buffer->value[e]);
      if (unknown < 0) csr_push(system->coupling, &coupled, point, buffer->value[e]);
    }
    system->matrix->start[++*next_row] = end;
    system->coupling->start[*next_row] = coupled;
  }
  return SCT_OK;
}

static sct_status assemble_rows(assembly *job, const sct_work *work, sct_error *err) {
  const int64_t n = job->system->n;
  int64_t next_row = 0;
  for (job->chunk_first = 0; job->chunk_first < n; job->chunk_first += CHUNK) {
    const int64_t end = job->chunk_first + CHUNK < n ? job->chunk_first + CHUNK : n;
    for (int64_t b = 0; b < job->blocks; b++) job->buffers[b].rows = job->buffers[b].entries = 0;
    sct_status status =
        sct_work_report(work, "assemble", (double)job->chunk_first / (double)n, err);
    if (status == SCT_OK) {
      status = sct_points_run(job->stencil, job->chunk_first, end, work, assemble_point, job, err);
    }
    for (int64_t b = 0; status == SCT_OK && b < job->blocks; b++) {
      status = append_block(job, &job->buffers[b], &next_row, err);
    }
    if (status != SCT_OK) return status;
  }
  return SCT_OK;
}

static void number_unknowns(sct_system *system, const uint8_t *condition) {
  int64_t row = 0;
  for (int64_t i = 0; i < system->n; i++) {
    system->row_of[i] = condition[i] == SCT_DIRICHLET ? -1 : (int32_t)row;
    if (condition[i] == SCT_DIRICHLET) continue;
    system->point_of[row] = (int32_t)i;
    system->is_equation[row++] = condition[i] == SCT_INTERIOR;
  }
}

static sct_status check_fields(int64_t n, const sct_fields *fields, bool *diffuses,
                               sct_error *err) {
  for (int64_t i = 0; i < n; i++) {
    const double mu = fields->diffusivity[i];
    if (!(mu >= 0 && isfinite(mu))) {
      return sct_fail(err, SCT_E_ARGUMENT, i, "has diffusivity %g, needs zero or more", mu);
    }
    *diffuses = *diffuses || mu > 0;
  }
  return SCT_OK;
}

static sct_status system_new(int64_t n, const uint8_t *condition, sct_system **out,
                             sct_error *err) {
  sct_system *system = NULL;
  sct_status status = sct_alloc_zero(&system, 1, sizeof *system, err);
  if (status != SCT_OK) return status;
  system->n = n;
  for (int64_t i = 0; i < n; i++) system->unknowns += condition[i] != SCT_DIRICHLET;
  const int64_t m = system->unknowns;
  status = sct_alloc(&system->row_of, n, sizeof *system->row_of, err);
  if (status == SCT_OK) status = sct_alloc(&system->point_of, m, sizeof *system->point_of, err);
  if (status == SCT_OK) {
    status = sct_alloc(&system->is_equation, m, sizeof *system->is_equation, err);
  }
  if (status == SCT_OK) status = sct_alloc(&system->load, m, sizeof *system->load, err);
  if (status == SCT_OK) status = sct_csr_new(m, m, 0, &system->matrix, err);
  if (status == SCT_OK) status = sct_csr_new(m, n, 0, &system->coupling, err);
  if (status == SCT_OK) number_unknowns(system, condition);
  if (status != SCT_OK) sct_system_free(&system);
  *out = system;
  return status;
}

static void count_flags(const assembly *job) {
  for (int64_t i = 0; i < job->system->n; i++) {
    job->system->widened += (job->flags[i] & SCT_ROW_WIDENED) != 0;
    job->system->fallback += (job->flags[i] & SCT_ROW_FALLBACK) != 0;
    job->system->loose += (job->flags[i] & SCT_ROW_LOOSE) != 0;
  }
}

static void assembly_clear(assembly *job) {
  for (int64_t b = 0; job->buffers != NULL && b < job->blocks; b++)
    row_buffer_clear(&job->buffers[b]);
  sct_release(&job->buffers);
  sct_release(&job->flags);
}

sct_status sct_system_build(const sct_stencil *stencil, const sct_fields *fields,
                            const sct_boundary *boundary, const sct_work *work, sct_system **out,
                            sct_error *err) {
  return sct_system_build_part(stencil, fields, boundary, false, work, out, err);
}

sct_status sct_system_build_part(const sct_stencil *stencil, const sct_fields *fields,
                                 const sct_boundary *boundary, bool diffuses, const sct_work *work,
                                 sct_system **out, sct_error *err) {
  const int64_t n = sct_stencil_cloud(stencil)->n;
  assembly job = {.stencil = stencil, .fields = fields, .boundary = boundary, .diffuses = diffuses};
  job.blocks = n < CHUNK ? (n + SCT_POINTS_BLOCK - 1) / SCT_POINTS_BLOCK : CHUNK_BLOCKS;
  *out = NULL;
  sct_status status = check_fields(n, fields, &job.diffuses, err);
  if (status == SCT_OK) status = system_new(n, boundary->condition, &job.system, err);
  if (status == SCT_OK && job.system->unknowns == 0) {
    status = sct_fail(err, SCT_E_ARGUMENT, -1, "every point has a given value, nothing to solve");
  }
  if (status == SCT_OK && sct_stencil_operator(stencil)->upwind == SCT_UPWIND_LIMITED) {
    status = sct_limited_new(sct_stencil_cloud(stencil), &job.system->limited, err);
  }
  if (status == SCT_OK) {
    status = sct_alloc_zero(&job.buffers, job.blocks, sizeof *job.buffers, err);
  }
  if (status == SCT_OK) status = sct_alloc_zero(&job.flags, n, sizeof *job.flags, err);
  if (status == SCT_OK) status = assemble_rows(&job, work, err);
  if (status == SCT_OK) {
    count_flags(&job);
    sct_system_load(job.system, fields->source, boundary->value);
  } else {
    sct_system_free(&job.system);
  }
  assembly_clear(&job);
  *out = job.system;
  return status;
}

void sct_system_free(sct_system **system) {
  if (*system == NULL) return;
  sct_release(&(*system)->row_of);
  sct_release(&(*system)->point_of);
  sct_release(&(*system)->is_equation);
  sct_release(&(*system)->load);
  sct_csr_free(&(*system)->matrix);
  sct_csr_free(&(*system)->coupling);
  sct_limited_free(&(*system)->limited);
  sct_release(system);
}

void sct_system_load(sct_system *system, const double *source, const double *value) {
  for (int64_t row = 0; row < system->unknowns; row++) {
    const double *from = system->is_equation[row] ? source : value;
    system->load[row] = from == NULL ? 0 : from[system->point_of[row]];
  }
}

void sct_system_rhs(const sct_system *system, const double *phi, double *b) {
  memcpy(b, system->load, (size_t)system->unknowns * sizeof *b);
  sct_csr_multiply_add(system->coupling, -1, phi, b);
}
