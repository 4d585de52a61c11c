#include "param.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "doc.h"
#include "log.h"
#include "param_inner.h"

/* ---- The table ---- */

#define AT(member) offsetof(parameters, member)

const parameter param_table[] = {
    {"listen", TEXT, "ADDR:PORT|unix:PATH", AT(listen), "127.0.0.1:8480", 1, 0,
     "where to listen; port 0 takes any free one and logs it"},
    {"data-dir", TEXT, "DIR", AT(data_dir), "", 0, 0,
     "directory of the daemon's files; empty means $XDG_DATA_HOME/scatterd or "
     "~/.local/share/scatterd"},
    {"store", STORE, "URL", AT(store), "", 0, 0,
     "database of the jobs, postgresql://..., which other daemons may share; empty means SQLite in "
     "data-dir"},
    {"lease-seconds", SECONDS, "s", AT(lease_seconds), "15", 1, 86400,
     "time without a sign of life after which others take the jobs of a daemon that shares store"},
    {"user", TEXT, "NAME", AT(user), "", 0, 0,
     "who to run as when started by root, once the socket is open; empty means no change"},
    {"public-url", URL, "URL", AT(public_url), "", 0, 0,
     "address of this service as clients see it, for links; empty means the Host of each request"},
    {"cors-origins", TEXT, "LIST", AT(cors_origins), "", 0, 0,
     "origins whose web pages may call, such as \"https://a.example https://b.example\"; * is any"},
    {"hosts", TEXT, "LIST", AT(hosts), "", 0, 0,
     "names by which clients call this service in Host, beside its own address; * is any. Without "
     "tokens others are refused, so that no web page can reach it under a name of its own"},
    {"tokens", TEXT, "FILE", AT(tokens), "", 0, 0,
     "who may use the service and how much, a line each, made by scatterd token NAME; empty means "
     "everybody who reaches it. Read again on SIGHUP"},
    {"allow-anonymous", COUNT, "", AT(allow_anonymous), "0", 0, 1,
     "1: listen on an address that other machines reach even without tokens"},
    {"open-metrics", COUNT, "", AT(open_metrics), "0", 0, 1,
     "1: /metrics needs no token; /healthz and /readyz never do"},
    {"tls-certificate", TEXT, "FILE", AT(tls_certificate), "", 0, 0,
     "certificate chain of this service (PEM): serve HTTPS only; empty means plain HTTP. Read "
     "again "
     "on SIGHUP"},
    {"tls-key", TEXT, "FILE", AT(tls_key), "", 0, 0,
     "private key of the certificate (PEM); empty means that it is in the same file"},
    {"log-level", LEVEL, "LEVEL", AT(log_level), "info", 0, 0,
     "what goes to the log: error, info (one line per request) or debug"},
    {"workers", COUNT, "", AT(workers), "0", 0, 1024,
     "worker processes, each solving one request at a time; 0 means one per processor, at least 2"},
    {"threads", COUNT, "", AT(limits.threads), "1", 1, 1024, "threads of one worker"},
    {"recycle", COUNT, "requests", AT(recycle), "1000", 1, PARAM_NO_END,
     "requests after which a worker is replaced by a fresh one"},
    {"executor", CHOICE, "local|mpi|slurm", AT(executor), "local", 0, 2,
     "where large jobs run: local is on a worker; mpi, on ranks of this machine; slurm, as a job "
     "of "
     "Slurm on nodes that share data-dir"},
    {"executor-points", COUNT, "", AT(limits.executor_points), "500000", 0, 2147483647,
     "points from which a job is large; mpi shares jobs of process solve"},
    {"executor-jobs", COUNT, "jobs", AT(executor_jobs), "0", 0, 1e6,
     "large jobs at the same time; 0 means 1 for mpi and 64 for slurm"},
    {"ranks", COUNT, "processes", AT(limits.ranks), "0", 0, 1e6,
     "that share a large job; 0 means one per processor of this machine, at least 2"},
    {"mpiexec", TEXT, "COMMAND", AT(mpiexec), "mpiexec", 1, 0,
     "what starts ranks, with its options; -n and the program are appended"},
    {"sbatch", TEXT, "COMMAND", AT(sbatch), "sbatch", 1, 0,
     "what submits a job to Slurm, with its options, such as \"sbatch --partition=long "
     "--mem-per-cpu=4G\""},
    {"queue", COUNT, "requests", AT(queue), "64", 0, 1e6,
     "requests that may wait for a worker; more are answered 503"},
    {"connections", COUNT, "", AT(connections), "1000", 1, 1e6, "connections at the same time"},
    {"connections-per-address", COUNT, "", AT(connections_per_address), "100", 0, 1e6,
     "connections of one address (of IPv6: one /64) at the same time, those of this machine apart; "
     "0 "
     "means no limit of its own"},
    {"receive-seconds", SECONDS, "s", AT(receive_seconds), "20", 0.1, 86400,
     "time a client has to send a request's header, and the longest pause in a body"},
    {"idle-seconds", SECONDS, "s", AT(idle_seconds), "75", 0.1, 86400,
     "time after which a connection without traffic is closed"},
    {"receive-rate", COUNT, "bytes/s", AT(receive_rate), "500", 1, PARAM_NO_END,
     "rate below which a body counts as too slow"},
    {"grace-seconds", SECONDS, "s", AT(grace_seconds), "30", 0, 86400,
     "time that running requests have to end after SIGTERM"},
    {"job-queue", COUNT, "jobs", AT(job_queue), "10000", 1, 1e7,
     "jobs that may wait; more are answered 429"},
    {"job-seconds", SECONDS, "s", AT(job_seconds), "86400", 0.01, 1e7,
     "time a worker has for one job"},
    {"job-attempts", COUNT, "", AT(job_attempts), "3", 1, 1000,
     "times a job is started when its worker or the daemon dies; then it has failed"},
    {"result-seconds", SECONDS, "s", AT(result_seconds), "604800", 1, 1e9,
     "time that a job and its results stay after its end"},
    {"job-bytes", BYTES, "bytes", AT(job_bytes), "20GiB", 0, PARAM_NO_END,
     "sum of the stored requests and results of all jobs; what would be more is answered 507"},
    {"reuse-results", COUNT, "", AT(reuse_results), "1", 0, 1,
     "1: a job may be answered with the stored result of an equal request; 0: each is computed"},
    {"batch-parts", COUNT, "requests", AT(batch_parts), "10000", 1, 1e6, "requests of one batch"},
    {"memory-budget", BYTES, "bytes", AT(memory_budget), "0", 0, PARAM_NO_END,
     "sum of the estimated memory of running jobs; 0 means three quarters of the machine's"},
    {"wait-seconds", SECONDS, "s", AT(wait_seconds), "60", 0, 86400,
     "longest wait that a client gets by Prefer: wait"},
    {"streams", COUNT, "", AT(streams), "200", 1, 1e6,
     "event streams at the same time; a token may have a limit of its own"},
    {"heartbeat-seconds", SECONDS, "s", AT(heartbeat_seconds), "15", 0.1, 86400,
     "longest silence of an event stream"},
    {"callback-hosts", TEXT, "LIST", AT(callback_hosts), "", 0, 0,
     "hosts that jobs may call when they end, such as \"hooks.example other.example:8443\"; empty "
     "means none"},
    {"callback-key", TEXT, "TEXT", AT(callback_key), "", 0, 0,
     "key that callbacks are signed with (HMAC-SHA-256)"},
    {"callback-attempts", COUNT, "", AT(callback_attempts), "6", 1, 100,
     "times a callback is tried, with growing pauses"},
    {"data-bytes", BYTES, "bytes", AT(data_bytes), "10GiB", 0, PARAM_NO_END,
     "sum of all objects under /data; what would be more is answered 507"},
    {"data-seconds", SECONDS, "s", AT(data_seconds), "604800", 1, 1e9,
     "time that an object under /data stays after it was last uploaded"},
    {"fetch-hosts", TEXT, "LIST", AT(fetch_hosts), "", 0, 0,
     "hosts from which inputs by href may be fetched, such as \"files.example\"; empty means none "
     "but this service"},
    {"fetch-private-hosts", TEXT, "LIST", AT(fetch_private), "", 0, 0,
     "those of fetch-hosts whose address may be a private one"},
    {"fetch-bytes", BYTES, "bytes", AT(fetch_bytes), "256MiB", 1, PARAM_NO_END,
     "one input fetched from another host"},
    {"fetch-seconds", SECONDS, "s", AT(fetch_seconds), "30", 0.1, 86400,
     "time to fetch one input from another host"},
    {"header-bytes", BYTES, "bytes", AT(header_bytes), "16KiB", 1024, 1 << 20,
     "request line and header fields"},
    {"body-bytes", BYTES, "bytes", AT(limits.body_bytes), "256MiB", 1, PARAM_NO_END,
     "body, as sent"},
    {"spool-bytes", BYTES, "bytes", AT(spool_bytes), "16MiB", 0, PARAM_NO_END,
     "bodies above this go to a file in data-dir instead of memory"},
    {"aside-bytes", BYTES, "bytes", AT(aside_bytes), "1MiB", 0, PARAM_NO_END,
     "bodies and results from this size on are hashed and written to disk by a second thread, so "
     "that nobody else waits meanwhile"},
    {"decoded-bytes", BYTES, "bytes", AT(limits.decoded_bytes), "1GiB", 1, PARAM_NO_END,
     "body after its Content-Encoding is undone"},
    {"depth", COUNT, "levels", AT(limits.depth), "64", 1, DOC_DEPTH_MAX, "nesting of a body"},
    {"nodes", COUNT, "", AT(limits.nodes), "1000000", 1, PARAM_NO_END,
     "values of a body, an array of numbers being one"},
    {"points", COUNT, "", AT(limits.points), "2000000", 1, 2147483647, "points of a cloud"},
    {"neighbours", COUNT, "", AT(limits.neighbours), "500", 1, 1e6, "neighbours of one point"},
    {"expression-bytes", BYTES, "bytes", AT(limits.expression_bytes), "4096", 1, 1 << 20,
     "text of one expression"},
    {"expression-work", COUNT, "operations", AT(limits.expression_work), "1G", 1, PARAM_NO_END,
     "operations of one expression times the points it is for, some 20 ns each"},
    {"steps", COUNT, "", AT(limits.steps), "1000000", 1, PARAM_NO_END,
     "steps of a time-dependent solve"},
    {"memory-bytes", BYTES, "bytes", AT(limits.memory_bytes), "4GiB", 256 << 20, PARAM_NO_END,
     "address space of one worker"},
    {"seconds", SECONDS, "s", AT(limits.seconds), "120", 0.01, 1e7,
     "time a worker has for one synchronous request"},
};

const int param_rows = sizeof param_table / sizeof *param_table;

static const parameter *find(const char *name) {
  for (int k = 0; k < param_rows; k++) {
    if (strcmp(param_table[k].name, name) == 0) return &param_table[k];
  }
  return NULL;
}

/* ---- Values: one reader and one writer per kind ---- */

static bool read_text(const parameter *row, void *value, const char *text, fault *why) {
  const size_t length = strlen(text);
  if (length >= PARAM_TEXT) {
    return fault_set(why, "%s: got %zu characters, needs at most %d", row->name, length,
                     PARAM_TEXT - 1);
  }
  if (length < (size_t)row->least) return fault_set(why, "%s: got an empty text", row->name);
  memcpy(value, text, length + 1);
  return true;
}

/* An empty text, or an URL that may stand in links: no blank, quote or control character. */
static bool read_url(const parameter *row, void *value, const char *text, fault *why) {
  bool good = strncmp(text, "http://", 7) == 0 || strncmp(text, "https://", 8) == 0;
  for (const char *at = text; *at != '\0'; at++) {
    good = good && *at > ' ' && *at <= '~' && strchr("\"<>\\^`{|}", *at) == NULL;
  }
  if (good || *text == '\0') return read_text(row, value, text, why);
  return fault_set(why, "%s: got \"%.200s\", needs http://... or https://...", row->name, text);
}

static bool read_store(const parameter *row, void *value, const char *text, fault *why) {
  const bool good =
      strncmp(text, "postgresql://", 13) == 0 || strncmp(text, "postgres://", 11) == 0;
  if (good || *text == '\0') return read_text(row, value, text, why);
  return fault_set(why, "%s: needs postgresql://..., got something else", row->name);
}

static const struct {
  const char *suffix;
  double factor;
} suffixes[] = {{"", 1},    {"KiB", 1 << 10}, {"MiB", 1 << 20}, {"GiB", 1 << 30},
                {"k", 1e3}, {"M", 1e6},       {"G", 1e9}};

/* A decimal number with one of the first `allowed` suffixes; NaN if `text` is anything else. */
static double number(const char *text, size_t allowed) {
  char *end = NULL;
  if (!isdigit((unsigned char)*text) && *text != '-' && *text != '.') return NAN;
  if (strpbrk(text, "xX") != NULL) return NAN;
  const double value = strtod(text, &end);
  while (*end == ' ') end++;
  for (size_t k = 0; k < allowed; k++) {
    if (strcmp(end, suffixes[k].suffix) == 0) return value * suffixes[k].factor;
  }
  return NAN;
}

double param_number(const char *text, bool bytes) {
  return number(text, bytes ? 4 : sizeof suffixes / sizeof *suffixes);
}

static bool in_range(const parameter *row, double value, bool whole, const char *text, fault *why) {
  if (value >= row->least && value <= row->most && (!whole || value == floor(value))) return true;
  return fault_set(why, "%s: got \"%.100s\", needs %s from %.15g to %.15g%s%s", row->name, text,
                   whole ? "an integer" : "a number", row->least, row->most,
                   *row->unit != '\0' ? " " : "", row->unit);
}

static bool read_integer(const parameter *row, void *value, const char *text, fault *why) {
  const double x = param_number(text, row->kind == BYTES);
  if (!in_range(row, x, true, text, why)) return false;
  *(int64_t *)value = (int64_t)x;
  return true;
}

static bool read_seconds(const parameter *row, void *value, const char *text, fault *why) {
  const double x = number(text, 1);
  if (!in_range(row, x, false, text, why)) return false;
  *(double *)value = x;
  return true;
}

static bool read_level(const parameter *row, void *value, const char *text, fault *why) {
  const int level = log_level_of(text);
  if (level < 0) {
    return fault_set(why, "%s: got \"%.100s\", needs error, info or debug", row->name, text);
  }
  *(int64_t *)value = level;
  return true;
}

/* Length of the name at `at` of a list with | between. */
static size_t name_length(const char *at) {
  return strcspn(at, "|");
}

static bool read_choice(const parameter *row, void *value, const char *text, fault *why) {
  int64_t k = 0;
  for (const char *at = row->unit; *at != '\0'; k++) {
    const size_t length = name_length(at);
    if (strlen(text) == length && strncmp(text, at, length) == 0) {
      *(int64_t *)value = k;
      return true;
    }
    at += length + (at[length] == '|');
  }
  return fault_set(why, "%s: got \"%.100s\", needs %s", row->name, text, row->unit);
}

static void show_text(const parameter *row, const void *value, char *room, size_t size) {
  (void)row;
  snprintf(room, size, "%s", (const char *)value);
}

static void show_integer(const parameter *row, const void *value, char *room, size_t size) {
  (void)row;
  snprintf(room, size, "%lld", (long long)*(const int64_t *)value);
}

static void show_seconds(const parameter *row, const void *value, char *room, size_t size) {
  (void)row;
  snprintf(room, size, "%.15g", *(const double *)value);
}

static void show_level(const parameter *row, const void *value, char *room, size_t size) {
  (void)row;
  snprintf(room, size, "%s", log_level_name((log_level) * (const int64_t *)value));
}

static void show_choice(const parameter *row, const void *value, char *room, size_t size) {
  const char *at = row->unit;
  for (int64_t k = *(const int64_t *)value; k > 0; k--) at += name_length(at) + 1;
  snprintf(room, size, "%.*s", (int)name_length(at), at);
}

static const struct {
  bool (*read)(const parameter *row, void *value, const char *text, fault *why);
  void (*show)(const parameter *row, const void *value, char *room, size_t size);
} kinds[] = {
    [TEXT] = {read_text, show_text},        [URL] = {read_url, show_text},
    [STORE] = {read_store, show_text},      [COUNT] = {read_integer, show_integer},
    [BYTES] = {read_integer, show_integer}, [SECONDS] = {read_seconds, show_seconds},
    [LEVEL] = {read_level, show_level},     [CHOICE] = {read_choice, show_choice},
};

static bool set(parameters *p, const parameter *row, const char *text, fault *why) {
  return kinds[row->kind].read(row, (char *)p + row->offset, text, why);
}

bool param_set(parameters *p, const char *name, const char *text, fault *why) {
  const parameter *row = find(name);
  if (row == NULL) return fault_set(why, "no parameter is called \"%.100s\"; see --help", name);
  return set(p, row, text, why);
}

void param_defaults(parameters *p) {
  fault why;
  memset(p, 0, sizeof *p);
  for (int k = 0; k < param_rows; k++) {
    if (!set(p, &param_table[k], param_table[k].initial, &why))
      abort(); /* a row above contradicts itself */
  }
}

const char *param_name(int row) {
  return row >= 0 && row < param_rows ? param_table[row].name : NULL;
}

const char *param_show(const parameters *p, int row, char *room, size_t size) {
  kinds[param_table[row].kind].show(&param_table[row], (const char *)p + param_table[row].offset,
                                    room, size);
  return room;
}
