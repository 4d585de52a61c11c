/* Runs a fuzz target on every file of some folders, as an ordinary test.
 *
 * usage: replay FOLDER...
 */
#include <dirent.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

#include "fuzz.h"

/* The whole file, exactly sized, so that a sanitizer sees any step beyond the end. */
static uint8_t *read_file(const char *path, size_t *size) {
  FILE *file = fopen(path, "rb");
  if (file == NULL) return NULL;
  fseek(file, 0, SEEK_END);
  long end = ftell(file);
  rewind(file);
  uint8_t *bytes = malloc(end > 0 ? (size_t)end : 1);
  *size = bytes == NULL ? 0 : fread(bytes, 1, (size_t)end, file);
  fclose(file);
  return bytes;
}

static int is_file(const struct dirent *entry) {
  return entry->d_name[0] != '.';
}

/* How many files the folder has; -1 if one of them cannot be read. */
static int replay(const char *folder) {
  struct dirent **entries = NULL;
  const int count = scandir(folder, &entries, is_file, alphasort);
  bool failed = false;
  for (int k = 0; k < count; k++) {
    char path[4096];
    size_t size;
    snprintf(path, sizeof path, "%s/%s", folder, entries[k]->d_name);
    uint8_t *bytes = read_file(path, &size);
    printf("%s\n", path);
    fflush(stdout);
    failed |= bytes == NULL;
    if (bytes != NULL) LLVMFuzzerTestOneInput(bytes, size);
    free(bytes);
    free(entries[k]);
  }
  free(entries);
  return failed ? -1 : count;
}

int main(int argc, char **argv) {
  int seeds = 0;
  for (int k = 1; k < argc; k++) {
    const int count = replay(argv[k]);
    if (count <= 0) {
      fprintf(stderr, "%s: no seeds, or one that cannot be read\n", argv[k]);
      return 1;
    }
    seeds += count;
  }
  printf("%d seeds\n", seeds);
  return seeds == 0;
}
