/* result.h - a result that was stored: all requested outputs of a run, and how they are wanted.
 *
 * The document, in CBOR: {"scatterd": "result 1", "process": id, "raw": bool, "points": n,
 * "outputs": {name: {"reference": bool, "format": media type?, "value": ...}, ...},
 * "coordinates": [n][dim]?}. It holds what GET /jobs/ID/results needs for any Accept; coordinates
 * only where fields are among the outputs and no output says where they are.
 * Proof: unit.render, fuzz.result.seeds
 */
#ifndef SCATTERD_RESULT_H
#define SCATTERD_RESULT_H

#include "perform.h"

typedef struct {
  const char *name;
  output_role role;
  bool is_object;
  bool by_reference;
  media format;     /* MEDIA_COUNT: none was asked for */
  const doc *value; /* never NULL */
  const char *href; /* set when rendered: where a reference points */
} result_output;

typedef struct {
  const process *process;
  bool is_raw;
  int64_t points;
  int count;
  result_output output[PROCESS_OUTPUTS_MAX];
  const doc *coordinates; /* NULL: there are none */
} result;

/* Writes the stored result of a request that has been run. */
void result_write(emit *e, const task *t, const performance *f);

/* Reads one. False, with t->error set, if it is none (or of another version of this program). */
bool result_read(task *t, const doc *stored, result *r);

/* The output of that name, NULL if there is none. */
const result_output *result_find(const result *r, const char *name);

/* The roles of all outputs, a bit each. */
unsigned result_roles(const result *r);

#endif
