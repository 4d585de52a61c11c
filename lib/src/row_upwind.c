/* row_upwind.c - the kernel W of the gradient in u . grad phi, by method. */
#include <math.h>

#include "length.h"
#include "row.h"

/* coth g - 1/g = g/3 - g^3/45 + 2 g^5/945 - ...; the two terms cancel for small g. */
double sct_upwind_beta(double gamma) {
  const double g = fabs(gamma);
  double beta;
  if (isnan(g)) return gamma;
  if (g < 0.02) {
    beta = g * (1.0 / 3 - g * g * (1.0 / 45 - g * g * 2.0 / 945));
  } else {
    beta = 1 / tanh(g) - 1 / g;
  }
  return gamma < 0 ? -beta : beta;
}

/* gamma = |u| h / (2 mu); without diffusion the limit beta = 1. */
static double beta_of(const row_job *job, double speed) {
  const double s = job->op->upwind == SCT_UPWIND_PUBLISHED ? job->op->gamma_scale : 1;
  if (job->request->diffusivity <= 0) return 1;
  return sct_upwind_beta(s * speed * job->spacing / (2 * job->request->diffusivity));
}

/* c = (u . r_j) / (|u| r) into `c` */
static void cosines(const row_job *job, double speed, double *c) {
  const sct_room *room = job->room;
  for (int64_t k = 0; k < job->n; k++) {
    double dot = 0;
    for (int a = 0; a < job->dim; a++) dot += job->velocity[a] * room->r[a][k];
    c[k] = dot / (speed * sqrt(room->r2[k]));
  }
}

/* Each method turns the cosines in W[k] into W itself. */
typedef void method(const row_job *job, double speed, double beta, double *W);

/* W = w - beta w(h) (w'(r) / w'(h)) c                                  [H11] eq. 23-28 */
static void exact(const row_job *job, double speed, double beta, double *W) {
  (void)speed;
  const sct_kernel *kernel = job->op->kernel;
  const double h = job->spacing / job->support;
  const double tau = beta * kernel->w(h) / kernel->slope(h);
  for (int64_t k = 0; k < job->n; k++) {
    W[k] = job->room->w[k] - tau * kernel->slope(sqrt(job->room->r2[k]) / job->support) * W[k];
  }
}

/* W = w (1 - beta c) */
static void cosine(const row_job *job, double speed, double beta, double *W) {
  (void)speed;
  for (int64_t k = 0; k < job->n; k++) W[k] = job->room->w[k] * (1 - beta * W[k]);
}

/* W = w - (16/5) (h/L) (|u|/U) beta c |c| / |w'(1/2)|: fits the tables of [H11] */
static void published(const row_job *job, double speed, double beta, double *W) {
  const sct_operator *op = job->op;
  const double tau = 16.0 / 5 * (job->spacing / op->reference_length) *
                     (speed / op->reference_speed) * beta / fabs(op->kernel->slope(0.5));
  for (int64_t k = 0; k < job->n; k++) W[k] = job->room->w[k] - tau * W[k] * fabs(W[k]);
}

static method *const methods[] = {
    [SCT_UPWIND_NONE] = NULL,           [SCT_UPWIND_EXACT] = exact,  [SCT_UPWIND_COSINE] = cosine,
    [SCT_UPWIND_PUBLISHED] = published, [SCT_UPWIND_LIMITED] = NULL,
};

bool row_is_limited(const row_job *job) {
  return job->velocity != NULL && job->op->upwind == SCT_UPWIND_LIMITED;
}

void row_upwind_weight(const row_job *job, double *weight) {
  const double speed = sct_length(job->velocity, job->dim);
  method *const make = methods[job->op->upwind];
  if (make == NULL || speed == 0) {
    for (int64_t k = 0; k < job->n; k++) weight[k] = job->room->f[k];
    return;
  }
  cosines(job, speed, weight);
  make(job, speed, beta_of(job, speed), weight);
  for (int64_t k = 0; k < job->n; k++) weight[k] /= job->room->r2[k];
}
