/* param.h - every parameter of the daemon, in one table (param.c) from which the command line, the
 * configuration file, --help and the reference page come. Test: unit.param.
 */
#ifndef SCATTERD_PARAM_H
#define SCATTERD_PARAM_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "fault.h"
#include "limit.h"

enum { PARAM_TEXT = 1024 };

typedef struct {
  char listen[PARAM_TEXT];
  char data_dir[PARAM_TEXT];
  char user[PARAM_TEXT];
  char store[PARAM_TEXT]; /* URL of a database; empty: SQLite in data_dir */
  double lease_seconds;
  char public_url[PARAM_TEXT];
  char cors_origins[PARAM_TEXT];
  char hosts[PARAM_TEXT];
  char tokens[PARAM_TEXT];
  int64_t allow_anonymous; /* 0 or 1 */
  int64_t open_metrics;    /* 0 or 1 */
  char tls_certificate[PARAM_TEXT];
  char tls_key[PARAM_TEXT];
  int64_t log_level; /* log_level of log.h */
  int64_t workers;
  int64_t recycle;  /* requests */
  int64_t executor; /* place in the list of its unit: local, mpi, slurm */
  int64_t executor_jobs;
  char mpiexec[PARAM_TEXT];
  char sbatch[PARAM_TEXT];
  int64_t queue; /* requests */
  int64_t connections;
  int64_t job_bytes;  /* of requests and results of all jobs */
  int64_t data_bytes; /* of all objects under /data */
  double data_seconds;
  char fetch_hosts[PARAM_TEXT];
  char fetch_private[PARAM_TEXT];
  int64_t fetch_bytes;
  double fetch_seconds;
  int64_t connections_per_address;
  int64_t spool_bytes;
  int64_t aside_bytes;
  int64_t header_bytes;
  int64_t receive_rate; /* bytes per second */
  double receive_seconds;
  double idle_seconds;
  double grace_seconds;
  int64_t job_queue; /* jobs */
  int64_t job_attempts;
  int64_t batch_parts;
  int64_t memory_budget; /* bytes; 0: three quarters of the machine's */
  int64_t reuse_results; /* 0 or 1 */
  int64_t streams;
  double job_seconds;
  double result_seconds;
  double wait_seconds;
  double heartbeat_seconds;
  char callback_hosts[PARAM_TEXT];
  char callback_key[PARAM_TEXT];
  int64_t callback_attempts;
  limits limits;
} parameters;

/* All defaults. */
void param_defaults(parameters *p);

/* Sets one parameter from its text. False with a message that says name, got and needed. */
bool param_set(parameters *p, const char *name, const char *text, fault *why);

/* Reads a configuration file: lines `name = value`; `#` starts a comment at the start of a line or
 * after a blank. False with file and line in the message. */
bool param_read(parameters *p, const char *path, fault *why);

/* Takes `--name value` and `--name=value` from argv[0 .. *count-1]; `--config FILE` is read first,
 * wherever it stands, so that the command line wins. What is no option stays in argv, in order, and
 * *count becomes its number; after `--` everything stays. */
bool param_take(parameters *p, int *count, char **argv, fault *why);

/* A decimal number as the options take it, with k, M, G, KiB, MiB or GiB behind it (`bytes`: only
 * the latter); NaN for anything else. */
double param_number(const char *text, bool bytes);

/* The option part of --help; the reference page in Markdown. */
void param_help(FILE *out);
void param_reference(FILE *out);

/* The manual page scatterd(1), in the man macros. */
void param_manual(FILE *out);

/* The value of parameter `row` as text a configuration file could hold; NULL past the last row. */
const char *param_name(int row);
const char *param_show(const parameters *p, int row, char *room, size_t size);

#endif
