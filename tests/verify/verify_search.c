/* The cost of the search, in points looked at and not in seconds: per point it does not grow with
 * the cloud, and no cloud makes it quadratic. */
#include <inttypes.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "clouds.h"
#include "search_feed.h"

typedef struct {
  int64_t runs, places;
} cost;

static bool add(void *into, int64_t first, int64_t last) {
  cost *c = into;
  c->runs++;
  c->places += last - first;
  return true;
}

/* Runs and places handed to the distance test per point, with the points of a bundle together,
 * for radii [n] by place. */
static void look_around_all(const sct_search *search, const double *radii, double *runs,
                            double *places) {
  cost all = {0, 0};
  for (int64_t p = 0, end; p < search->n; p = end) {
    cost one = {0, 0};
    end = search->kind->bundle_end(search, p);
    sct_box box = sct_box_of(search, p);
    double radius = 0;
    for (int64_t q = p; q < end; q++) {
      sct_box_add(&box, search, q);
      radius = fmax(radius, radii[q]);
    }
    search->kind->walk(search, &box, radius, add, &one);
    all.runs += one.runs;
    all.places += one.places * (end - p);
  }
  *runs = (double)all.runs / (double)search->n;
  *places = (double)all.places / (double)search->n;
}

static sct_search *build(const sct_cloud *cloud, sct_search_method method) {
  sct_error err;
  sct_search *search = NULL;
  if (sct_search_build(cloud, 0, method, NULL, &search, &err) != SCT_OK) fail_msg("%s", err.text);
  return search;
}

static void cost_of(sct_search_method method, int dim, int64_t n, double *runs, double *places) {
  sct_cloud cloud = cloud_make(CLOUD_UNIFORM, dim, n, 3);
  sct_search *search = build(&cloud, method);
  double *radii = malloc((size_t)n * sizeof *radii);
  for (int64_t p = 0; p < n; p++) radii[p] = 2.1 * pow((double)n, -1.0 / dim);
  look_around_all(search, radii, runs, places);
  free(radii);
  sct_search_free(&search);
  cloud_free(&cloud);
}

/* From 1e4 points to 64 times as many (leaves are as full again) the work per point stays the same
 * but for the boundary, whose points have less of it. */
static void is_linear(void **state) {
  (void)state;
  for (int method = SCT_SEARCH_GRID; method <= SCT_SEARCH_TREE; method++) {
    for (int dim = 1; dim <= 3; dim++) {
      double runs[2], places[2];
      cost_of((sct_search_method)method, dim, 10000, &runs[0], &places[0]);
      cost_of((sct_search_method)method, dim, 640000, &runs[1], &places[1]);
      print_message("%s %d-D: %.2f and %.2f runs, %.1f and %.1f places per point\n",
                    sct_search_method_name((sct_search_method)method), dim, runs[0], runs[1],
                    places[0], places[1]);
      assert_true(places[1] < 1.3 * places[0] && places[1] > 0.7 * places[0]);
      assert_true(runs[1] < 1.3 * runs[0]);
    }
  }
}

/* With the radius that each point needs, three times the distance of its nearest neighbour, no
 * cloud costs much more per point than a uniform one. */
static void no_cloud_is_bad(void **state) {
  (void)state;
  const int64_t n = 50000;
  double uniform[3];
  double *distance = malloc((size_t)n * sizeof *distance),
         *radii = malloc((size_t)n * sizeof *radii);
  for (int kind = 0; kind < CLOUDS; kind++) {
    for (int dim = 1; dim <= 3; dim++) {
      sct_cloud cloud = cloud_make(kind, dim, n, 5);
      sct_search *search = build(&cloud, SCT_SEARCH_AUTO);
      sct_status status = sct_search_nearest(search, NULL, distance, NULL);
      assert_true(status == SCT_OK || status == SCT_E_COINCIDENT);
      double outlier = 0, runs, places;
      for (int64_t p = 0; p < search->n; p++) {
        radii[p] = 3 * distance[search->order[p]] * search->scale;
        if (kind == CLOUD_OUTLIER && radii[p] > radii[(int64_t)outlier]) outlier = (double)p;
      }
      if (kind == CLOUD_OUTLIER) radii[(int64_t)outlier] = 0; /* it sees everybody, once */
      look_around_all(search, radii, &runs, &places);
      print_message("%s %d-D, %s: %.2f runs, %.1f places per point\n", cloud_names[kind], dim,
                    sct_search_method_name(sct_search_kind(search)), runs, places);
      if (kind == CLOUD_UNIFORM) uniform[dim - 1] = places;
      assert_true(places < 4 * uniform[dim - 1]);
      sct_search_free(&search);
      cloud_free(&cloud);
    }
  }
  free(distance);
  free(radii);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(is_linear),
      cmocka_unit_test(no_cloud_is_bad),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
