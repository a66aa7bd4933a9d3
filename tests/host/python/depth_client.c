/* depth_client HOST:PORT FRAMES [FOLDER]: what a C program gets of a sensor, to hold Python
 * against. With FOLDER each frame's depth goes to FOLDER/NUMBER.depth, rows of uint16_t. Without it
 * finds the largest depth of each. Prints the frames, the seconds of processor and the largest
 * depth.
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <stof/stof.h>
#include <sys/resource.h>

static const uint16_t *row_of(const stof_plane *plane, uint32_t y) {
  return (const void *)((const char *)plane->data + y * plane->stride);
}

static int save(const stof_frame *frame, const char *folder) {
  char name[4096];
  if (snprintf(name, sizeof name, "%s/%" PRIu32 ".depth", folder, frame->number) >=
      (int)sizeof name) {
    return 0;
  }
  FILE *file = fopen(name, "wb");
  if (file == NULL) {
    return 0;
  }
  int good = 1;
  for (uint32_t y = 0; y < frame->depth.height; ++y) {
    good &= fwrite(row_of(&frame->depth, y), 2, frame->depth.width, file) == frame->depth.width;
  }
  return (fclose(file) == 0) & good;
}

static uint16_t largest_of(const stof_plane *plane) {
  uint16_t largest = 0;
  for (uint32_t y = 0; y < plane->height; ++y) {
    const uint16_t *row = row_of(plane, y);
    for (uint32_t x = 0; x < plane->width; ++x) {
      largest = row[x] > largest ? row[x] : largest;
    }
  }
  return largest;
}

int main(int argc, char **argv) {
  if (argc < 3) {
    fprintf(stderr, "usage: depth_client HOST:PORT FRAMES [FOLDER]\n");
    return 2;
  }
  stof_options options = STOF_INIT(stof_options);
  options.sensor = argv[1];
  char why[200];
  stof_sensor *sensor = NULL;
  if (stof_open(&options, &sensor, why, sizeof why) != STOF_OK) {
    fprintf(stderr, "%s\n", why);
    return 2;
  }
  const int wanted = atoi(argv[2]);
  int frames = 0;
  uint16_t largest = 0;
  stof_frame frame = STOF_INIT(stof_frame);
  while (frames < wanted && stof_next(sensor, 20000, &frame) == STOF_OK) {
    if (argc > 3 && frame.missing_packets == 0 && !save(&frame, argv[3])) {
      fprintf(stderr, "%s cannot be written to\n", argv[3]);
      return 1;
    }
    const uint16_t here = largest_of(&frame.depth);
    largest = here > largest ? here : largest;
    ++frames;
  }
  stof_close(sensor);
  struct rusage used;
  getrusage(RUSAGE_SELF, &used);
  printf("%d %.3f %u\n", frames,
         (double)used.ru_utime.tv_sec + (double)used.ru_stime.tv_sec +
             (double)(used.ru_utime.tv_usec + used.ru_stime.tv_usec) * 1e-6,
         largest);
  return frames == wanted ? 0 : 1;
}
