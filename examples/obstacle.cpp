// obstacle HOST[:PORT] [FRAMES]: what is nearest ahead of a robot 0.6 m wide and 0.4 m high.
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include <stof/stof.hpp>

int main(int argc, char** argv) {
  std::string why = "usage: obstacle HOST[:PORT] [FRAMES]";
  auto sensor = argc > 1 ? stof::Sensor::open(argv[1], &why) : std::nullopt;
  if (!sensor) {
    return std::fprintf(stderr, "%s\n", why.c_str()), 2;
  }
  std::vector<stof::Point> points;  // metres: x right, y down, z ahead
  for (int frames = argc > 2 ? std::atoi(argv[2]) : 300; frames > 0; --frames) {
    const auto frame = sensor->next(std::chrono::seconds(1));
    if (!frame || frame->points(points) != STOF_OK) {
      points.clear();  // silence, or before the first calibration: one comes each second
    }
    const stof::Point* nearest = nullptr;
    for (const stof::Point& point : points) {
      const bool ahead = std::abs(point.x) < 0.3F && std::abs(point.y) < 0.2F;
      nearest = ahead && (!nearest || point.z < nearest->z) ? &point : nearest;
    }
    if (nearest) {  // it is there within -+ half of its width, in 95 percent
      std::printf("frame %u: %.2f m, -+ %.2f m\n", frame->number(), nearest->z,
                  nearest->z_width / 2);
    } else {
      std::puts("stop: no depth");
    }
  }
}
