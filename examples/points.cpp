// points HOST[:PORT] [FRAMES]: prints the nearest point of each frame.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include <stof/stof.hpp>

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: points HOST[:PORT] [FRAMES]\n");
    return 2;
  }
  const int wanted = argc > 2 ? std::atoi(argv[2]) : 30;

  std::string why;
  std::optional<stof::Sensor> sensor = stof::Sensor::open(argv[1], &why);
  if (!sensor) {
    std::fprintf(stderr, "%s\n", why.c_str());
    return 2;
  }

  std::vector<stof::Point> points;
  int frames = 0;
  int silent = 0;  // seconds
  while (frames < wanted && silent < 10) {
    const std::optional<stof::Frame> frame = sensor->next(std::chrono::seconds(1));
    if (!frame) {
      ++silent;
      continue;
    }
    silent = 0;
    ++frames;
    if (frame->points(points) != STOF_OK || points.empty()) {
      std::printf("frame %u: no points\n", frame->number());
      continue;
    }
    const stof::Point* nearest = &points[0];
    for (const stof::Point& point : points) {
      nearest = point.z < nearest->z ? &point : nearest;
    }
    std::printf("frame %u: %dx%d, %zu points, the nearest at %.3f %.3f %.3f m (%s)\n",
                frame->number(), frame->depth().width(), frame->depth().height(), points.size(),
                nearest->x, nearest->y, nearest->z, stof_source_name(nearest->source));
  }

  if (const std::optional<stof::Health> health = sensor->health()) {
    std::printf("health: %s, %.1f Hz\n", stof_severity_name(health->severity), health->rate_hz);
  }
  const std::string advice = sensor->advice();
  if (!advice.empty()) {
    std::printf("%s\n", advice.c_str());
  }
  const stof::Statistics statistics = sensor->statistics();
  std::printf("%llu frames, %llu packets missing\n",
              static_cast<unsigned long long>(statistics.frames_complete),
              static_cast<unsigned long long>(statistics.packets_missing));
  return frames == wanted ? 0 : 1;
}
