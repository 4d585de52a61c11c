/* search_feed.h - from the runs of a structure to the distance test.
 *
 * The points around a box are copied side by side into a scan; then everyone in the box asks the
 * scan. Where a scan does not hold them all, `full` is told.
 */
#ifndef SCATTER_SEARCH_FEED_H
#define SCATTER_SEARCH_FEED_H

#include "search_kind.h"
#include "search_scan.h"

typedef struct sct_feed sct_feed;
struct sct_feed {
  const sct_search *search;
  bool (*full)(sct_feed *feed); /* tests and empties the scan; false to end the walk */
  bool ended;
  sct_scan scan;
};

/* A `full` for those who ask together, each of whom must see all of the scan: ends the walk. */
bool sct_feed_give_up(sct_feed *feed);

void sct_feed_init(sct_feed *feed, const sct_search *search);

/* Fills the scan with all points less than radius away from a box, in the order of places. False
 * if `full` ended it. */
bool sct_feed_around(sct_feed *feed, const sct_box *box, double radius);

/* Fills the scan with a run that it can hold. */
void sct_feed_run(sct_feed *feed, int64_t first, int64_t last);

/* The box of one place; makes a box hold another place. */
sct_box sct_box_of(const sct_search *search, int64_t place);
void sct_box_add(sct_box *box, const sct_search *search, int64_t place);

#endif
