/* main.c - scatterd: the command line. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "child.h"
#include "counter.h"
#include "front.h"
#include "param.h"
#include "rank.h"
#include "route.h"
#include "token.h"
#include "worker.h"

static const char usage[] =
    "scatterd: partial differential equations on scattered particle clouds, over HTTP\n\n"
    "  scatterd [options]                 serve\n"
    "  scatterd run [options] REQUEST     answer one request (.json, .cbor; - is standard input)\n"
    "      --process ID                   which process (solve)\n"
    "      -o FILE                        where the result goes (standard output)\n"
    "  scatterd token NAME [LIMIT=VALUE...]\n"
    "                                     make a token: its line of the file of tokens goes to "
    "the\n"
    "                                     standard output, its secret to the error output\n"
    "  scatterd --help | --version | --print-parameters | --print-manual |\n"
    "           --print-metrics | --print-routes\n\n"
    "Options, with their defaults; --config FILE reads them from lines `name = value`:\n";

static int complain(const char *text) {
  fprintf(stderr, "scatterd: %s\n", text);
  return 2;
}

static int print_help(void) {
  fputs(usage, stdout);
  param_help(stdout);
  return 0;
}

static int print_version(void) {
  puts("scatterd " SCATTERD_VERSION);
  return 0;
}

static int print_parameters(void) {
  param_reference(stdout);
  return 0;
}

static int print_metrics(void) {
  counter_reference(stdout);
  return 0;
}

static int print_routes(void) {
  route_print(stdout);
  return 0;
}

static int print_manual(void) {
  param_manual(stdout);
  return 0;
}

/* Words that stand alone. `worker` is how the front starts its workers. */
static const struct {
  const char *word;
  int (*run)(void);
} words[] = {{"--help", print_help},           {"-h", print_help},
             {"--version", print_version},     {"--print-parameters", print_parameters},
             {"--print-manual", print_manual}, {"--print-metrics", print_metrics},
             {"--print-routes", print_routes}, {"worker", worker_main}};

/* Takes `name VALUE` out of argv; NULL if it is not there. */
static const char *take(int *count, char **argv, const char *name) {
  for (int k = 0; k + 1 < *count; k++) {
    if (strcmp(argv[k], name) != 0) continue;
    const char *value = argv[k + 1];
    memmove(argv + k, argv + k + 2, (size_t)(*count - k - 2) * sizeof *argv);
    *count -= 2;
    return value;
  }
  return NULL;
}

/* A BLAS reads its environment when it is loaded, so the program starts over with a worker's: then
 * `run` computes what the daemon would, to the last bit. */
static void start_over(const parameters *set, char **line) {
  if (getenv("OPENBLAS_NUM_THREADS") != NULL) return;
  child_environment(set->limits.threads);
  execv("/proc/self/exe", line); /* if it fails, the answer differs in rounding at most */
}

/* argv[-2 .. count] is the whole line, as main got it. */
static int run(parameters *set, int count, char **argv) {
  char *line[count + 3];
  memcpy(line, argv - 2, (size_t)(count + 3) * sizeof *line);
  const char *process = take(&count, argv, "--process");
  const char *out = take(&count, argv, "-o");
  fault why;
  if (!param_take(set, &count, argv, &why)) return complain(why.text);
  if (count != 1) return complain("run: needs one request file; see --help");
  start_over(set, line);
  return worker_run(process != NULL ? process : "solve", argv[0], out, &set->limits);
}

/* So `scatterd token alice >> FILE` adds the line and shows the secret, which nobody keeps. */
static int make_token(int count, char **argv) {
  char secret[TOKEN_SECRET], line[TOKEN_LINE];
  fault why;
  if (count == 0) return complain("token: needs a name; see --help");
  if (!token_make(argv[0], count - 1, argv + 1, secret, line, &why)) return complain(why.text);
  puts(line);
  fprintf(stderr, "secret of %s: %s\n", argv[0], secret);
  return 0;
}

static int serve(parameters *set, int count, char **argv) {
  fault why;
  if (!param_take(set, &count, argv, &why)) return complain(why.text);
  if (count == 0) return front_main(set);
  snprintf(why.text, sizeof why.text, "got \"%.200s\", needs options only; see --help", argv[0]);
  return complain(why.text);
}

int main(int argc, char **argv) {
  parameters set;
  for (size_t k = 0; argc == 2 && k < sizeof words / sizeof *words; k++) {
    if (strcmp(argv[1], words[k].word) == 0) return words[k].run();
  }
  if (argc == 3 && strcmp(argv[1], "rank") == 0) return rank_main(argv[2]); /* by an executor */
  param_defaults(&set);
  if (argc > 1 && strcmp(argv[1], "run") == 0) return run(&set, argc - 2, argv + 2);
  if (argc > 1 && strcmp(argv[1], "token") == 0) return make_token(argc - 2, argv + 2);
  return serve(&set, argc - 1, argv + (argc > 0));
}
