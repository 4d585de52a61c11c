/* page.h - the dashboard: one page and its scripts and styles, for browsers. The page is asked for
 * anew every time (no-cache, with an ETag); what it loads is named by its content and kept for ever
 * (immutable). A strict Content-Security-Policy lets it run, load and call nothing that is not of
 * this daemon. Test: http.dashboard, browser.*.
 */
#ifndef SCATTERD_PAGE_H
#define SCATTERD_PAGE_H

#include "exchange.h"

/* Was the daemon built with its dashboard? */
bool page_exists(void);

/* Replies with the page. */
void page_serve(exchange *x);

/* Replies with a script or style of the page; 404 if there is no such. */
void page_serve_asset(exchange *x, const char *name);

#endif
