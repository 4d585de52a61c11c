/* Accepting jobs: an order becomes a job with its parts, whose request is kept before its row. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <unistd.h>

#include "job_inner.h"

static bool make_id(char id[JOB_ID]) {
  uint8_t bytes[(JOB_ID - 1) / 2];
  if (getrandom(bytes, sizeof bytes, 0) != (ssize_t)sizeof bytes) return false;
  for (size_t k = 0; k < sizeof bytes; k++) snprintf(id + 2 * k, 3, "%02x", bytes[k]);
  return true;
}

/* A new job as the order has it. */
static job *job_of_order(jobs *j, const job_order *o) {
  job_row row = o->row;
  if (!make_id(row.id)) return NULL;
  row.state = JOB_ACCEPTED;
  row.created = row.updated = unix_now();
  snprintf(row.message, sizeof row.message, "waits for a worker");
  for (int k = 0; k < 3; k++) row.subscribed |= *o->extra->uri[k] != '\0';
  job *c = job_new(j, &row);
  if (c == NULL) return NULL;
  c->stored = o->stored;
  c->stored_self = o->self;
  c->extra = malloc(sizeof *c->extra);
  if (c->extra != NULL) {
    *c->extra = *o->extra;
    return c;
  }
  job_free(c);
  return NULL;
}

static job *part_of(job *batch, const job_part *p, int place) {
  job_row row = batch->row;
  if (!make_id(row.id)) return NULL;
  memcpy(row.process, p->process, sizeof row.process);
  row.content = MEDIA_CBOR;
  row.content_coding = CODING_IDENTITY;
  row.offset = p->offset;
  row.size = p->size;
  row.points = p->points;
  row.estimate = p->estimate;
  row.part = place;
  row.parts = row.reusable = row.subscribed = 0;
  job *c = job_new(batch->all, &row);
  if (c != NULL) c->batch = batch;
  return c;
}

static void free_with_parts(job *c) {
  while (c->parts != NULL) {
    job *part = c->parts;
    c->parts = part->sibling;
    job_free(part);
  }
  job_free(c);
}

static bool add_parts(job *c, const job_part *parts) {
  job **end = &c->parts;
  for (int k = 0; k < c->row.parts; k++) {
    *end = part_of(c, &parts[k], k);
    if (*end == NULL) return false;
    end = &(*end)->sibling;
  }
  return true;
}

int job_places(const job *c) {
  return c->row.parts > 0 ? c->row.parts : 1;
}

/* While a large request was being kept, an equal one may have come and gone the same way. A shared
 * store finds that out itself. */
static bool is_key_taken(const job *c) {
  jobs *j = c->all;
  job_row other;
  char digest[JOB_DIGEST];
  if (*c->extra->key == '\0' || c->row.size < j->set->aside_bytes) return false;
  return store_by_key(jobs_store(j), c->row.submitter, c->extra->key, &other, digest) == STORE_OK;
}

/* Its request is kept. */
static void accept_job(job *c, int error) {
  jobs_hold(c->all, -job_places(c));
  if (error != 0 || is_key_taken(c)) {
    job_refuse(c, error != 0 ? store_blame("job", error) : STORE_TAKEN);
    return;
  }
  c->row.created = c->row.updated = unix_now(); /* which may have been set since */
  for (job *part = c->parts; part != NULL; part = part->sibling) {
    part->row.created = part->row.updated = c->row.created;
  }
  job_save(c);
}

store_result jobs_add(jobs *j, const job_order *order) {
  job *c = job_of_order(j, order);
  if (c != NULL && add_parts(c, order->parts)) {
    jobs_hold(j, job_places(c));
    job_files_keep(c, JOB_REQUEST, order->body, (size_t)c->row.size, accept_job);
    return STORE_OK;
  }
  if (c != NULL) free_with_parts(c);
  if (order->body >= 0) close(order->body);
  return STORE_FAILED;
}

store_result jobs_add_answered(jobs *j, const job_order *order, const job_row *other) {
  job *c = job_of_order(j, order);
  if (c == NULL) return STORE_FAILED;
  if (!job_files_copy(c, other)) {
    const store_result result = store_blame("job", errno);
    job_free(c);
    return result;
  }
  c->row.result_size = other->result_size;
  c->row.result_coding = other->result_coding;
  c->row.started = c->row.created;
  c->row.progress = 100;
  job_become(c, JOB_SUCCESSFUL, "answered with the result of job %s, an equal request", other->id);
  return STORE_OK;
}

void jobs_forget(jobs *j, void *self) {
  for (job *c = j->changed; c != NULL; c = c->next_changed) {
    if (c->stored_self == self) c->stored = NULL;
  }
  job_files_orphan(j, self);
}
