/* watch HOST[:PORT] [FRAMES]: frames on the library's own thread.
 *   cc main.c $(pkg-config --cflags --libs stof) -o watch
 */
#include <inttypes.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <stof/stof.h>
#include <threads.h>

static atomic_int frames;

static void on_frame(void *user, const stof_frame *frame) {
  (void)user;
  uint32_t x = frame->depth.width / 2;
  uint32_t y = frame->depth.height / 2;
  uint16_t depth = 0;
  if (frame->depth.data != NULL) {
    const char *row = (const char *)frame->depth.data + y * frame->depth.stride;
    depth = ((const uint16_t *)(const void *)row)[x];
  }
  double unit = frame->has_calibration ? frame->calibration.depth_unit_m : 0.00025;
  printf("frame %" PRIu32 ": %.3f m straight ahead\n", frame->number, depth * unit);
  atomic_fetch_add(&frames, 1);
}

static void on_event(void *user, const stof_event *event) {
  (void)user;
  printf("%s: %s, the robot should: %s\n", stof_condition_name(event->condition),
         event->active ? "began" : "ended", stof_reaction_name(event->reaction));
}

int main(int argc, char **argv) {
  if (argc < 2) {
    fprintf(stderr, "usage: watch HOST[:PORT] [FRAMES]\n");
    return 2;
  }
  int wanted = argc > 2 ? atoi(argv[2]) : 30;

  stof_options options = STOF_INIT(stof_options);
  options.sensor = argv[1];
  char why[200];
  stof_sensor *sensor = NULL;
  if (stof_open(&options, &sensor, why, sizeof why) != STOF_OK) {
    fprintf(stderr, "%s\n", why);
    return 2;
  }

  stof_callbacks callbacks = STOF_INIT(stof_callbacks);
  callbacks.frame = on_frame;
  callbacks.event = on_event;
  stof_status status = stof_start(sensor, &callbacks);
  for (int i = 0; status == STOF_OK && i < 100 && atomic_load(&frames) < wanted; ++i) {
    thrd_sleep(&(struct timespec){.tv_nsec = 100000000}, NULL);
  }
  stof_stop(sensor);

  stof_statistics statistics = STOF_INIT(stof_statistics);
  if (stof_get_statistics(sensor, &statistics) == STOF_OK) {
    printf("libstof %s: %" PRIu64 " frames, %" PRIu64 " packets missing\n", stof_version(),
           statistics.frames_complete, statistics.packets_missing);
  }
  stof_close(sensor);
  return atomic_load(&frames) >= wanted ? 0 : 1;
}
