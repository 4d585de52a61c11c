/* expression_slope.h - derivatives of expressions with respect to a parameter, by differences.
 *
 * Expressions are evaluated, not known as formulas, so this is the one place where a derivative is
 * not exact: central differences over steps that are halved, extrapolated to step 0 (Ridders 1982),
 * point by point the extrapolation of least estimated error. Exact up to rounding for expressions
 * linear in the parameter, 1e-12 relative for smooth ones as measured. At a corner (abs, step,
 * ? :) it means nothing.
 * Proof: unit.expression_slope
 */
#ifndef SCATTERD_EXPRESSION_SLOPE_H
#define SCATTERD_EXPRESSION_SLOPE_H

#include "field_input.h"

/* slope [n] = d e / d name at the points `on` and `time`, the parameter being `value`. False with
 * t->error: SCT_E_MEMORY, SCT_E_NOT_FINITE where there is none (with the place). */
bool expression_slope(task *t, const expression *e, const sites *on, double time, const char *name,
                      double value, double *slope);

#endif
