/* Parts are stretches of the curve that hold every point once, and their halos are what brute force
 * finds, on all kinds of clouds, also with some supports wider than others. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "clouds.h"
#include "fixture.h"

enum { POINTS = 400 };

static double distance2(const sct_cloud *cloud, int64_t i, int64_t j) {
  double sum = 0;
  for (int a = 0; a < cloud->dim; a++) {
    const double d = cloud->x[i * cloud->dim + a] - cloud->x[j * cloud->dim + a];
    sum += d * d;
  }
  return sum;
}

static int owner(const sct_partition *p, const sct_cloud *cloud, int64_t point) {
  int64_t place = p->place != NULL ? p->place[point] : point;
  assert_int_equal(sct_partition_point(p, place), point);
  assert_int_equal(cloud->n, p->n);
  int k = 0;
  while (sct_partition_start(p, k + 1) <= place) k++;
  return k;
}

static bool is_in_halo(const sct_cloud *cloud, const int *owns, int k, double width,
                       const double *reach, int64_t j) {
  for (int64_t i = 0; i < cloud->n; i++) {
    const double w = reach != NULL && reach[i] > width ? reach[i] : width;
    if (owns[i] == k && distance2(cloud, i, j) < w * w) return true;
  }
  return false;
}

static void expect_part(const sct_cloud *cloud, const sct_partition *p, const int *owns, int k,
                        double width, const double *reach) {
  sct_part *part;
  sct_error err;
  int64_t m = 0;
  expect_ok(sct_part_build(cloud, p, k, width, reach, NULL, &part, &err), &err);
  assert_int_equal(part->own, sct_partition_start(p, k + 1) - sct_partition_start(p, k));
  for (int64_t j = 0; j < cloud->n; j++) {
    const bool own = owns[j] == k;
    if (!own && !is_in_halo(cloud, owns, k, width, reach, j)) continue;
    assert_true(m < part->n);
    assert_int_equal(part->point[m], j);
    assert_int_equal(part->is_own[m], own);
    assert_memory_equal(part->cloud.x + m * cloud->dim, cloud->x + j * cloud->dim,
                        (size_t)cloud->dim * sizeof(double));
    m++;
  }
  assert_int_equal(part->n, m);
  sct_part_free(&part);
}

static void check(const sct_cloud *cloud, int parts, bool along, const double *reach) {
  sct_partition *p;
  sct_error err;
  int owns[POINTS];
  expect_ok(sct_partition_build(cloud, parts, along, &p, &err), &err);
  assert_int_equal(sct_partition_start(p, 0), 0);
  assert_int_equal(sct_partition_start(p, parts), cloud->n);
  for (int64_t i = 0; i < cloud->n; i++) owns[i] = owner(p, cloud, i);
  for (int k = 0; k < parts; k++) {
    expect_part(cloud, p, owns, k, 0.07, NULL);
    expect_part(cloud, p, owns, k, 0.07, reach);
  }
  sct_partition_free(&p);
}

static void halos_are_those_of_brute_force(void **state) {
  (void)state;
  static const int counts[] = {1, 2, 3, 16};
  for (int kind = 0; kind < CLOUDS; kind++) {
    for (int dim = 1; dim <= 3; dim++) {
      sct_cloud cloud = cloud_make(kind, dim, POINTS, 3);
      double reach[POINTS];
      uint64_t stream = 5;
      for (int64_t i = 0; i < cloud.n; i++) {
        reach[i] = cloud_random(&stream) < 0.02 ? 0.07 + 0.2 * cloud_random(&stream) : 0;
      }
      for (size_t c = 0; c < sizeof counts / sizeof *counts; c++) {
        check(&cloud, counts[c], c % 2 == 0, reach);
      }
      cloud_free(&cloud);
    }
  }
}

/* More parts than points: some are empty. */
static void parts_may_be_empty(void **state) {
  (void)state;
  const double x[] = {0, 1, 2};
  const sct_cloud cloud = {1, 3, x};
  sct_partition *p;
  sct_part *part;
  sct_error err;
  int64_t own = 0;
  expect_ok(sct_partition_build(&cloud, 5, false, &p, &err), &err);
  for (int k = 0; k < 5; k++) {
    expect_ok(sct_part_build(&cloud, p, k, 1.5, NULL, NULL, &part, &err), &err);
    own += part->own;
    if (part->own == 0) assert_int_equal(part->n, 0);
    sct_part_free(&part);
  }
  assert_int_equal(own, 3);
  sct_partition_free(&p);
  assert_int_equal(sct_partition_build(&cloud, 0, false, &p, &err), SCT_E_ARGUMENT);
  assert_null(p);
}

/* Along the curve a part of n points has a halo that grows like its surface. */
static void halos_are_small(void **state) {
  (void)state;
  for (int dim = 2; dim <= 3; dim++) {
    const int64_t cells = dim == 2 ? 127 : 25;
    const sct_operator op = sct_operator_default(SCT_PS, 2);
    fixture f = fixture_unit(dim, cells, 0.3, 9, &op);
    sct_partition *p;
    sct_part *part;
    sct_error err;
    expect_ok(sct_partition_build(&f.cloud, 16, false, &p, &err), &err);
    for (int k = 0; k < 16; k++) {
      expect_ok(sct_part_build(&f.cloud, p, k, 2 * f.spacing, NULL, NULL, &part, &err), &err);
      const double side = pow((double)part->own, 1.0 / dim), halo = (double)(part->n - part->own);
      assert_true(halo <= 2 * (pow(side + 4, dim) - pow(side, dim)));
      sct_part_free(&part);
    }
    sct_partition_free(&p);
    fixture_clear(&f);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(halos_are_those_of_brute_force),
      cmocka_unit_test(parts_may_be_empty),
      cmocka_unit_test(halos_are_small),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
