// mavlink_frames COUNT FRAMES EXPECTED: writes COUNT messages of each kind, one after the other,
// with noise between some of them, and what a reader should find in them, one JSON object a line.

#include <array>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <span>
#include <utility>

#include "firmware/serial/mavlink/mavlink.h"
#include "tests/support/random.h"

namespace stof::firmware::test {
namespace {

using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;
using namespace mavlink;

class Frames {
 public:
  Frames(File frames, File expected) : frames_(std::move(frames)), expected_(std::move(expected)) {}

  void write(int round) {
    const State state = static_cast<State>(random_.between(4, 6));
    put(writer_.write(Heartbeat{.state = state}, buffer_));
    std::fprintf(expected_.get(),
                 R"({"msgid":0,"systemStatus":%d,"type":18,"autopilot":8,"mavlinkVersion":3})"
                 "\n",
                 static_cast<int>(state));
    write_obstacle();
    write_distance(round % 4 == 0);
    if (round % 10 == 0) {
      std::array<std::byte, 20> noise{};
      random_.fill(std::span<std::byte>(noise), 0, 250);  // without a first byte of a message
      put(noise);
    }
  }

 private:
  void put(std::span<const std::byte> bytes) {
    std::fwrite(bytes.data(), 1, bytes.size(), frames_.get());
  }

  void write_obstacle() {
    ObstacleDistance message{
        .time_us = random_.next() >> 12,
        .least_cm = static_cast<std::uint16_t>(random_.between(0, 50)),
        .most_cm = static_cast<std::uint16_t>(random_.between(100, 1638)),
        .increment_deg = static_cast<float>(random_.between(1, 1'000'000)) * 1e-6F,
        .angle_offset_deg = static_cast<float>(random_.between(-60'000'000, 0)) * 1e-6F};
    for (std::uint16_t& distance : message.distances_cm) {
      distance = static_cast<std::uint16_t>(random_.between(0, 3) == 0 ? kUnknownDistance
                                                                       : random_.between(0, 1638));
    }
    put(writer_.write(message, buffer_));
    std::FILE* const out = expected_.get();
    std::fprintf(
        out,
        R"({"msgid":330,"timeUsec":"%llu","minDistance":%d,"maxDistance":%d,"incrementF":%.9g,)"
        R"("angleOffset":%.9g,"frame":12,"sensorType":4,"increment":0,"distances":[)",
        static_cast<unsigned long long>(message.time_us), message.least_cm, message.most_cm,
        static_cast<double>(message.increment_deg), static_cast<double>(message.angle_offset_deg));
    for (std::size_t i = 0; i < kDirections; ++i) {
      std::fprintf(out, "%s%d", i == 0 ? "" : ",", message.distances_cm[i]);
    }
    std::fprintf(out, "]}\n");
  }

  // `bare`: the extensions are zero, and not sent.
  void write_distance(bool bare) {
    const DistanceSensor message{
        .time_boot_ms = static_cast<std::uint32_t>(random_.next()),
        .least_cm = static_cast<std::uint16_t>(random_.between(0, 50)),
        .most_cm = static_cast<std::uint16_t>(random_.between(100, 1638)),
        .distance_cm = static_cast<std::uint16_t>(random_.between(0, 1638)),
        .variance_cm2 = static_cast<std::uint8_t>(random_.between(0, 255)),
        .horizontal_fov_rad = bare ? 0 : static_cast<float>(random_.between(1, 999)) * 1e-3F,
        .vertical_fov_rad = bare ? 0 : static_cast<float>(random_.between(1, 999)) * 1e-3F,
        .quality = static_cast<std::uint8_t>(bare ? 0 : random_.between(1, 100))};
    put(writer_.write(message, buffer_));
    std::fprintf(
        expected_.get(),
        R"({"msgid":132,"timeBootMs":%u,"minDistance":%d,"maxDistance":%d,"currentDistance":%d,)"
        R"("type":4,"id":0,"orientation":0,"covariance":%d,"horizontalFov":%.9g,)"
        R"("verticalFov":%.9g,"quaternion":[0,0,0,0],"signalQuality":%d})"
        "\n",
        message.time_boot_ms, message.least_cm, message.most_cm, message.distance_cm,
        message.variance_cm2, static_cast<double>(message.horizontal_fov_rad),
        static_cast<double>(message.vertical_fov_rad), message.quality);
  }

  File frames_;
  File expected_;
  stof::test::Random random_{7};
  Writer writer_{42, 196};
  Buffer buffer_{};
};

int run(int count, const char* frames, const char* expected) {
  File first(std::fopen(frames, "wb"), std::fclose);
  File second(std::fopen(expected, "w"), std::fclose);
  if (first == nullptr || second == nullptr) {
    std::fprintf(stderr, "mavlink_frames: cannot write '%s' or '%s'\n", frames, expected);
    return 1;
  }
  Frames out(std::move(first), std::move(second));
  for (int i = 0; i < count; ++i) {
    out.write(i);
  }
  return 0;
}

}  // namespace
}  // namespace stof::firmware::test

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: mavlink_frames COUNT FRAMES EXPECTED\n");
    return 2;
  }
  return stof::firmware::test::run(std::atoi(argv[1]), argv[2], argv[3]);
}
