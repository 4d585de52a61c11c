/* scatter.h - partial differential equations on scattered particles. Read in this order. */
#ifndef SCATTER_SCATTER_H
#define SCATTER_SCATTER_H

#include "scatter/adjoint.h"   /* a march differentiated */
#include "scatter/assemble.h"  /* equation and boundary to a system */
#include "scatter/cloud.h"     /* points */
#include "scatter/csr.h"       /* sparse matrices */
#include "scatter/diagnose.h"  /* what the cloud does to the operators, norms */
#include "scatter/flow.h"      /* flow on moving particles */
#include "scatter/flow_case.h" /* cavity and step */
#include "scatter/kernel.h"    /* weights */
#include "scatter/limited.h"   /* convection by slope-limited edges */
#include "scatter/march.h"     /* or marched in time */
#include "scatter/partition.h" /* clouds in parts, for many processes */
#include "scatter/ranks.h"     /* systems solved by them */
#include "scatter/search.h"    /* neighbours */
#include "scatter/slope.h"     /* how a system changes with its data */
#include "scatter/solve.h"     /* the system solved */
#include "scatter/status.h"    /* codes and errors */
#include "scatter/stencil.h"   /* gradient and Laplacian as rows */

#endif
