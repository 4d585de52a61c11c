/* data_routes.h - POST /data, GET and DELETE /data/{id}. Test: http.data.
 */
#ifndef SCATTERD_DATA_ROUTES_H
#define SCATTERD_DATA_ROUTES_H

#include "exchange.h"
#include "service.h"

/* An upload: JSON, CBOR, .npy or CSV. A worker reads it through before it is kept. */
void data_begin(const service *s, exchange *x);
void data_serve(const service *s, exchange *x);
void data_end(const service *s, exchange *x);

/* The bytes as they came, in parts too. */
void data_get(const service *s, exchange *x);
void data_delete(const service *s, exchange *x);

#endif
