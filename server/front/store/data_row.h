/* data_row.h - what is stored of an object under /data: one row of the table `data`.
 */
#ifndef SCATTERD_DATA_ROW_H
#define SCATTERD_DATA_ROW_H

#include <stdint.h>

enum { DATA_ID = 65 /* 64 hexadecimal digits and a NUL */, DATA_TYPE = 128, DATA_OWNER = 64 };

typedef struct {
  char id[DATA_ID]; /* SHA-256 of the bytes, of an owner's of the owner and the bytes */
  char type[DATA_TYPE];
  char owner[DATA_OWNER]; /* name of the token that it was uploaded with, "" without one */
  int64_t size;
  double created, expires; /* seconds since 1970 */
} data_row;

#endif
