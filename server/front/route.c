#include "route.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bridge.h"
#include "clock.h"
#include "data_routes.h"
#include "events.h"
#include "execute.h"
#include "field.h"
#include "gate.h"
#include "job_list.h"
#include "job_routes.h"
#include "media.h"
#include "metrics.h"
#include "negotiate.h"
#include "page.h"
#include "site.h"

static const char html[] = "text/html; charset=utf-8";
static const char openapi[] = "application/vnd.oai.openapi+json;version=3.0";

/* ---- Small handlers ---- */

static void serve_json(exchange *x, const char *name) {
  if (negotiate_json(x)) site_serve(x, name, media_type(MEDIA_JSON));
}

static void get_landing(const service *s, exchange *x) {
  (void)s;
  const char *const offers[] = {media_type(MEDIA_JSON), html};
  const int chosen = negotiate(x, offers, 2);
  if (chosen == 0) site_serve(x, "landing.json", offers[0]);
  if (chosen == 1 && page_exists()) page_serve(x);
  if (chosen == 1 && !page_exists()) site_serve_page(x, "landing.html");
}

static void get_asset(const service *s, exchange *x) {
  (void)s;
  page_serve_asset(x, x->item);
}

static void get_api(const service *s, exchange *x) {
  (void)s;
  const char *const offers[] = {openapi, media_type(MEDIA_JSON), html};
  const int chosen = negotiate(x, offers, 3);
  if (chosen == 0 || chosen == 1) site_serve(x, "openapi.json", offers[chosen]);
  if (chosen == 2) site_serve_page(x, "api.html");
}

static void get_conformance(const service *s, exchange *x) {
  (void)s;
  serve_json(x, "conformance.json");
}

static void get_processes(const service *s, exchange *x) {
  (void)s;
  const char *text = http_argument(x, "limit");
  char *end = NULL;
  const long limit = text != NULL ? strtol(text, &end, 10) : 10000;
  if (text != NULL && (*text < '0' || *text > '9' || *end != '\0' || limit < 1 || limit > 10000)) {
    exchange_refuse(x, 400, "limit: got \"%.100s\", needs an integer from 1 to 10000", text);
    return;
  }
  if (negotiate_json(x)) site_processes(x, limit);
}

static void get_process(const service *s, exchange *x) {
  (void)s;
  char name[128];
  problem p;
  if (site_has_process(x->item)) {
    snprintf(name, sizeof name, "processes/%s.json", x->item);
    serve_json(x, name);
    return;
  }
  problem_begin_type(&p, PROBLEM_NO_SUCH_PROCESS, 404, "there is no process \"%.64s\"", x->item);
  exchange_problem(x, &p);
}

static void get_healthz(const service *s, exchange *x) {
  (void)s;
  exchange_text(x, 200, media_type(MEDIA_JSON), "{\"status\":\"ok\"}");
}

/* ---- The table ---- */

typedef enum { OWNERS, WATCHERS, EVERYBODY } visitors; /* who needs no token, where there are any */

typedef struct {
  const char *method;
  const char *path; /* {} stands for one segment: exchange.item, item2 */
  void (*begin)(const service *s, exchange *x); /* NULL: the route takes no body */
  void (*serve)(const service *s, exchange *x);
  void (*end)(const service *s, exchange *x); /* NULL: nothing to do */
  visitors who;
} route;

static const route table[] = {
    {"GET", "/", NULL, get_landing, NULL, OWNERS},
    {"GET", "/assets/{}", NULL, get_asset, NULL, OWNERS},
    {"GET", "/api", NULL, get_api, NULL, OWNERS},
    {"GET", "/conformance", NULL, get_conformance, NULL, OWNERS},
    {"GET", "/processes", NULL, get_processes, NULL, OWNERS},
    {"GET", "/processes/{}", NULL, get_process, NULL, OWNERS},
    {"POST", "/processes/{}/execution", execute_begin, execute_serve, execute_end, OWNERS},
    {"GET", "/jobs", NULL, job_list_serve, NULL, OWNERS},
    {"GET", "/jobs/{}", NULL, job_status_serve, job_status_end, OWNERS},
    {"DELETE", "/jobs/{}", NULL, job_dismiss_serve, NULL, OWNERS},
    {"GET", "/jobs/{}/events", NULL, events_serve, events_end, OWNERS},
    {"GET", "/jobs/{}/results", NULL, job_results_serve, job_results_end, OWNERS},
    {"GET", "/jobs/{}/results/{}", NULL, job_results_serve, job_results_end, OWNERS},
    {"GET", "/Info", NULL, bridge_info, NULL, OWNERS},
    {"POST", "/ModelInfo", bridge_begin, bridge_serve, bridge_end, OWNERS},
    {"POST", "/InputSizes", bridge_begin, bridge_serve, bridge_end, OWNERS},
    {"POST", "/OutputSizes", bridge_begin, bridge_serve, bridge_end, OWNERS},
    {"POST", "/Evaluate", bridge_begin, bridge_serve, bridge_end, OWNERS},
    {"POST", "/Gradient", bridge_begin, bridge_serve, bridge_end, OWNERS},
    {"POST", "/ApplyJacobian", bridge_begin, bridge_serve, bridge_end, OWNERS},
    {"POST", "/ApplyHessian", bridge_begin, bridge_serve, bridge_end, OWNERS},
    {"POST", "/data", data_begin, data_serve, data_end, OWNERS},
    {"GET", "/data/{}", NULL, data_get, NULL, OWNERS},
    {"DELETE", "/data/{}", NULL, data_delete, NULL, OWNERS},
    {"GET", "/healthz", NULL, get_healthz, NULL, EVERYBODY},
    {"GET", "/readyz", NULL, metrics_ready, NULL, EVERYBODY},
    {"GET", "/metrics", NULL, metrics_serve, NULL, WATCHERS},
};

enum { ROWS = sizeof table / sizeof *table };

void route_print(FILE *out) {
  for (int k = 0; k < ROWS; k++) fprintf(out, "%s %s\n", table[k].method, table[k].path);
}

/* Does `path` fit `pattern`? Then item[k] is what the k-th {} stands for, "" without one. */
static bool fits(const char *pattern, const char *path, char item[2][EXCHANGE_ITEM]) {
  *item[0] = *item[1] = '\0';
  for (int k = 0; *pattern != '\0';) {
    if (*pattern != '{') {
      if (*pattern++ != *path++) return false;
      continue;
    }
    const size_t length = strcspn(path, "/");
    if (length == 0) return false;
    /* What is longer than any name is cut, and is still the name of nothing. */
    snprintf(item[k++], EXCHANGE_ITEM, "%.*s", (int)length, path);
    path += length;
    pattern += 2;
  }
  return *path == '\0';
}

/* HEAD is GET without the body, which http.c leaves out. */
static bool is_method(const route *r, const char *method) {
  return strcmp(r->method, method) == 0 ||
         (strcmp(r->method, "GET") == 0 && strcmp(method, "HEAD") == 0);
}

/* Finds the route of an exchange; `allow` is the list of methods its path has, "" if the path is
 * unknown. */
static const route *find(exchange *x, char allow[64]) {
  const route *found = NULL;
  size_t used = 0;
  char item[2][EXCHANGE_ITEM];
  *allow = '\0';
  for (int k = 0; k < ROWS; k++) {
    if (!fits(table[k].path, x->path, item)) continue;
    memcpy(x->item, item[0], sizeof x->item);
    memcpy(x->item2, item[1], sizeof x->item2);
    used += (size_t)snprintf(allow + used, 64 - used, "%s%s, ", table[k].method,
                             strcmp(table[k].method, "GET") == 0 ? ", HEAD" : "");
    if (is_method(&table[k], x->method)) found = &table[k];
  }
  if (used > 0) snprintf(allow + used, 64 - used, "OPTIONS");
  return found;
}

/* ---- Other origins (the Fetch standard's CORS protocol) ---- */

static void add_cors(const service *s, exchange *x) {
  char room[512];
  if (*s->set->cors_origins == '\0') return;
  exchange_add(x, "Vary", "Origin");
  const char *origin = http_field(x, "Origin", room, sizeof room);
  if (origin == NULL || !host_lists(s->set->cors_origins, origin)) return;
  exchange_add(x, "Access-Control-Allow-Origin", "%s", origin);
  exchange_add(x, "Access-Control-Expose-Headers",
               "Accept-Ranges, Content-Location, Content-Range, ETag, Link, Location, "
               "Preference-Applied, Retry-After, X-Request-Id");
}

static void answer_options(exchange *x, const char *allow) {
  exchange_add(x, "Allow", "%s", allow);
  exchange_add(x, "Access-Control-Allow-Methods", "%s", allow);
  exchange_add(
      x, "Access-Control-Allow-Headers",
      "Accept, Authorization, Cache-Control, Content-Type, Content-Encoding, Idempotency-Key, "
      "If-None-Match, If-Range, Last-Event-ID, Prefer, Range, X-Request-Id");
  exchange_add(x, "Access-Control-Max-Age", "86400");
  exchange_text(x, 204, "", "");
}

/* Is this a page of ours? Browsers say so in Sec-Fetch-Site, which no page can set, or in Origin.
 */
static bool is_own_page(const exchange *x, const char *origin) {
  char room[64];
  const char *site = http_field(x, "Sec-Fetch-Site", room, sizeof room);
  const size_t length = strlen(origin);
  if (site != NULL && strcmp(site, "same-origin") == 0) return true;
  return strncmp(x->base, origin, length) == 0 && strchr("/", x->base[length]) != NULL;
}

/* A browser lets any page send simple requests to anybody, with the password that it knows for them
 * or from behind a firewall. Pages of others may only ask what changes nothing; they cannot read
 * the answer. */
static bool is_forged(const service *s, const exchange *x) {
  char room[512];
  static const char *const safe[] = {"GET", "HEAD", "OPTIONS"};
  for (size_t k = 0; k < sizeof safe / sizeof *safe; k++) {
    if (strcmp(x->method, safe[k]) == 0) return false;
  }
  const char *origin = http_field(x, "Origin", room, sizeof room);
  return origin != NULL && !is_own_page(x, origin) && !host_lists(s->set->cors_origins, origin);
}

/* ---- The handler ---- */

/* A path of UM-Bridge, whatever the method. */
static bool is_of_model(const route *r) {
  return r->serve == bridge_serve || r->serve == bridge_info;
}

static void look(void *self, exchange *x) {
  char item[2][EXCHANGE_ITEM];
  (void)self;
  for (int k = 0; k < ROWS && !x->model_error; k++) {
    x->model_error = is_of_model(&table[k]) && fits(table[k].path, x->path, item);
  }
}

/* Does it need a token? */
static bool is_open(const service *s, const route *r) {
  return r != NULL && (r->who == EVERYBODY || (r->who == WATCHERS && s->set->open_metrics));
}

/* False if the request is refused before anybody asks what it wants. */
static bool may_come(const service *s, exchange *x, const route *r) {
  if (is_forged(s, x)) {
    exchange_refuse(x, 403, "Origin: web pages of other origins may not send %s (cors-origins)",
                    x->method);
    return false;
  }
  return is_open(s, r) || gate_check(s->gate, x);
}

static void begin(void *self, exchange *x) {
  const service *s = self;
  char allow[64];
  clock_watch_look(s->clock);
  add_cors(s, x);
  const route *r = find(x, allow);
  if (strcmp(x->path, "*") == 0) snprintf(allow, sizeof allow, "GET, HEAD, POST, DELETE, OPTIONS");
  x->route = r;
  const bool is_question =
      strcmp(x->method, "OPTIONS") == 0; /* which browsers ask without a token */
  if (!is_question && !may_come(s, x, r)) return;
  if (*allow == '\0') {
    exchange_refuse(x, 404, "there is nothing at %.200s", x->path);
  } else if (is_question) {
    answer_options(x, allow);
  } else if (r == NULL) {
    exchange_add(x, "Allow", "%s", allow);
    exchange_refuse(x, 405, "%s: got %s, needs one of %s", x->path, x->method, allow);
  } else if (r->begin != NULL) {
    r->begin(s, x);
  } else if (x->declared != 0) {
    r->serve(s, x); /* it does not want the body: http.c replies and closes */
  }
}

static void serve(void *self, exchange *x) {
  const route *r = x->route;
  r->serve(self, x);
}

static void end(void *self, exchange *x) {
  const service *s = self;
  const route *r = x->route;
  metrics_count(x, r != NULL ? r->path : "none");
  if (r != NULL && r->end != NULL) r->end(s, x);
  clerk_close(s->clerk, spool_take(&x->body));
}

http_handler route_handler(service *s) {
  return (http_handler){s, look, begin, serve, end};
}
