/* model.h - the model `solve` of UM-Bridge: a solve whose parameters are the input and whose
 * functionals are the output. What a request says of it, read and checked.
 *
 * `config` is a solve request: {"inputs": {the inputs of process solve}}, all its `parameters`
 * being one input vector in their order; or the inputs of process solve themselves with beside them
 * "inputs": names of parameters, in one list for one vector or in a list of lists. "outputs" names
 * the functionals (functional.h), in a list or an object, one output vector each; without it, the
 * mean. No config, or an empty one, is the problem of schemas/um-bridge/default.json.
 * Test: http.um_bridge.
 */
#ifndef SCATTERD_MODEL_H
#define SCATTERD_MODEL_H

#include "functional.h"

extern const char model_name[]; /* "solve" */

/* Vectors of named numbers. */
typedef struct {
  int64_t vectors;
  int64_t *first;    /* [vectors+1] of the numbers of a vector */
  const char **name; /* [first[vectors]] */
  double *value;     /* [first[vectors]] */
} model_inputs;

typedef struct {
  solve solve; /* read, not computed */
  model_inputs in;
  int64_t outputs;
  functional *output;  /* [outputs] */
  doc_arena *arena;    /* of the default config */
  bool is_unsupported; /* cannot be differentiated, which was asked for */
} model;

/* Reads config and, where `with_input`, the input, into the zeroed *m. False with complaints or
 * t->error. */
bool model_read(task *t, const item *body, bool with_input, model *m);
void model_clear(model *m);

/* One of the numbered vectors, "outWrt" or "inWrt", of `count`; its `size` numbers, "sens" or
 * "vec". False with a complaint. */
bool model_read_index(task *t, const item *body, const char *key, int64_t count, int64_t *index);
bool model_read_vector(task *t, const item *it, int64_t size, double *value);

#endif
