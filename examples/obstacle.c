/* obstacle_c HOST[:PORT] [FRAMES]: what is nearest ahead of a robot 0.6 m wide and 0.4 m high. */
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <stof/stof.h>

static stof_point points[1280 * 800]; /* metres: x right, y down, z ahead */

int main(int argc, char** argv) {
  stof_options options = STOF_INIT(stof_options);
  options.sensor = argv[1];
  char why[200] = "usage: obstacle_c HOST[:PORT] [FRAMES]";
  stof_sensor* sensor = NULL;
  if (argc < 2 || stof_open(&options, &sensor, why, sizeof why) != STOF_OK) {
    return fprintf(stderr, "%s\n", why), 2;
  }
  for (int frames = argc > 2 ? atoi(argv[2]) : 300; frames > 0; --frames) {
    stof_frame frame = STOF_INIT(stof_frame);
    size_t count = 0;
    if (stof_next(sensor, 1000, &frame) != STOF_OK ||
        stof_points(&frame, points, sizeof points / sizeof *points, &count) != STOF_OK) {
      count = 0; /* silence, or before the first calibration: one comes each second */
    }
    const stof_point* nearest = NULL;
    for (const stof_point* point = points; point < points + count; ++point) {
      const bool ahead = fabsf(point->x) < 0.3F && fabsf(point->y) < 0.2F;
      nearest = ahead && (!nearest || point->z < nearest->z) ? point : nearest;
    }
    if (nearest) { /* it is there within -+ half of its width, in 95 percent */
      printf("frame %u: %.2f m, -+ %.2f m\n", frame.number, nearest->z, nearest->z_width / 2);
    } else {
      puts("stop: no depth");
    }
  }
  stof_close(sensor);
  return 0;
}
