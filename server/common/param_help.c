/* The table in words: --help, PARAMETERS.md, the manual page. */
#include <stdio.h>

#include "param_inner.h"

void param_help(FILE *out) {
  for (int k = 0; k < param_rows; k++) {
    const parameter *row = &param_table[k];
    fprintf(out, "  --%s %s\n        %s", row->name, *row->unit != '\0' ? row->unit : "N",
            row->help);
    if (*row->initial != '\0') fprintf(out, " (%s)", row->initial);
    fputc('\n', out);
  }
}

static void print_range(FILE *out, const parameter *row) {
  if (row->most <= row->least) {
    fputs(" |", out);
  } else if (row->most >= PARAM_NO_END) {
    fprintf(out, " at least %.15g |", row->least);
  } else {
    fprintf(out, " %.15g to %.15g |", row->least, row->most);
  }
}

void param_reference(FILE *out) {
  fputs(
      "# Parameters of scatterd\n\n"
      "Each is an option `--name value` of the command line and a line `name = value` of the file\n"
      "that `--config FILE` names; the command line wins. Sizes take KiB, MiB and GiB.\n\n"
      "| name | default | unit | range | meaning |\n|---|---|---|---|---|\n",
      out);
  for (int k = 0; k < param_rows; k++) {
    const parameter *row = &param_table[k];
    fprintf(out, "| %s | %s | ", row->name, row->initial);
    for (const char *at = row->unit; *at != '\0'; at++)
      fprintf(out, *at == '|' ? "\\|" : "%c", *at);
    fputs(" |", out);
    print_range(out, row);
    fprintf(out, " %s |\n", row->help);
  }
}

/* In the man macros a line that starts with . or ' is a request, and a backslash an escape; no text
 * of the table has either. */
static void print_option(FILE *out, const parameter *row) {
  fprintf(out, ".TP\n.BI \\-\\-%s \" %s\"\n%s", row->name, *row->unit != '\0' ? row->unit : "N",
          row->help);
  if (*row->initial != '\0') fprintf(out, " (default: %s)", row->initial);
  fputs(".\n", out);
}

void param_manual(FILE *out) {
  fputs(
      ".TH SCATTERD 1\n.SH NAME\n"
      "scatterd \\- solves partial differential equations on scattered points, over HTTP\n"
      ".SH SYNOPSIS\n"
      ".B scatterd\n[\\-\\-config \\fIFILE\\fR] [\\fIoptions\\fR]\n.br\n"
      ".B scatterd run\n[\\-\\-process \\fIID\\fR] [\\-o \\fIFILE\\fR] [\\fIoptions\\fR] "
      "\\fIREQUEST\\fR\n.br\n"
      ".B scatterd token\n\\fINAME\\fR [\\fILIMIT\\fR=\\fIVALUE\\fR...]\n"
      ".SH DESCRIPTION\n"
      "The first form serves: OGC API \\- Processes at the address of \\-\\-listen, described by\n"
      "the service itself under / and /api. The second answers one request from a file (.json\n"
      "or .cbor; \\- is the standard input) without a server. The third makes a token: its line\n"
      "of the file of \\-\\-tokens goes to the standard output, its secret to the error output;\n"
      "limits are jobs, points, seconds, body-bytes, data-bytes, job-bytes, streams, rate and\n"
      "burst.\n"
      ".SH OPTIONS\n"
      "Each may stand in the file of \\-\\-config as a line name = value; the command line wins.\n"
      "Sizes take KiB, MiB and GiB.\n",
      out);
  for (int k = 0; k < param_rows; k++) print_option(out, &param_table[k]);
  fputs(
      ".SH SIGNALS\nSIGTERM and SIGINT end the daemon after the running requests; a second one "
      "at once. SIGHUP reads the tokens and the certificate again; what cannot be read stays as it "
      "was, and the log says why.\n"
      ".SH EXIT STATUS\n0 after serving or answering, 1 when that failed, 2 for a wrong command "
      "line.\n"
      ".SH FILES\n"
      ".TP\n.I /etc/scatterd/scatterd.conf\noptions of the packaged service\n"
      ".TP\n.I /var/lib/scatterd\nits data\n",
      out);
}
