#include "search_feed.h"

#include <string.h>

bool sct_feed_give_up(sct_feed *feed) {
  (void)feed;
  return false;
}

void sct_feed_init(sct_feed *feed, const sct_search *search) {
  feed->search = search;
  feed->full = sct_feed_give_up;
  sct_scan_init(&feed->scan, search->dim);
}

static void copy(sct_feed *feed, int64_t first, int64_t n) {
  const sct_search *search = feed->search;
  sct_scan *scan = &feed->scan;
  for (int k = 0; k < search->dim; k++) {
    memcpy(scan->x[k] + scan->n, search->x[k] + first, (size_t)n * sizeof(double));
  }
  memcpy(scan->point + scan->n, search->order + first, (size_t)n * sizeof(int32_t));
  scan->n += n;
}

static bool take(void *into, int64_t first, int64_t last) {
  sct_feed *feed = into;
  while (first < last) {
    int64_t room = SCT_SCAN_MOST - feed->scan.n, n = last - first < room ? last - first : room;
    copy(feed, first, n);
    first += n;
    if (first == last) break;
    sct_scan_close(&feed->scan);
    feed->ended = !feed->full(feed);
    if (feed->ended) return false;
  }
  return true;
}

bool sct_feed_around(sct_feed *feed, const sct_box *box, double radius) {
  feed->ended = false;
  feed->scan.n = 0;
  feed->search->kind->walk(feed->search, box, radius, take, feed);
  sct_scan_close(&feed->scan);
  return !feed->ended;
}

void sct_feed_run(sct_feed *feed, int64_t first, int64_t last) {
  feed->scan.n = 0;
  copy(feed, first, last - first);
  sct_scan_close(&feed->scan);
}

sct_box sct_box_of(const sct_search *search, int64_t place) {
  sct_box box = {{0}, {0}};
  for (int k = 0; k < search->dim; k++) box.lower[k] = box.upper[k] = search->x[k][place];
  return box;
}

void sct_box_add(sct_box *box, const sct_search *search, int64_t place) {
  for (int k = 0; k < search->dim; k++) {
    double x = search->x[k][place];
    box->lower[k] = x < box->lower[k] ? x : box->lower[k];
    box->upper[k] = x > box->upper[k] ? x : box->upper[k];
  }
}
