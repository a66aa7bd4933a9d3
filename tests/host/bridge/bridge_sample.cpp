#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <random>
#include <thread>
#include <vector>

#include "host/bridge/dds/publisher.h"
#include "host/bridge/robot_feed.h"

// bridge_sample DOMAIN NAMESPACE COUNT: so many messages of each topic, of small random pictures,
// once every topic has a reader; each message waits until the one before has been read. Ends with 1
// where nobody came, or nobody acknowledged, within a minute.
namespace stof {
namespace {

constexpr int kWidth = 33;
constexpr int kHeight = 7;
constexpr std::chrono::seconds kPatience{60};

unsigned number_of(const char* text) {
  unsigned number = 0;
  std::from_chars(text, text + std::strlen(text), number);
  return number;
}

bool all_read(bridge::Publisher& publisher) {
  for (std::size_t k = 0; k < bridge::kTopics; ++k) {
    if (!publisher.wanted(static_cast<bridge::Topic>(k))) {
      return false;
    }
  }
  return true;
}

int publish(bridge::Publisher& publisher, const char* name_space, unsigned count) {
  bridge::RobotFeed feed(publisher, {.name_space = name_space, .cloud_step = 2});
  const auto until = std::chrono::steady_clock::now() + kPatience;
  while (!all_read(publisher)) {
    if (std::chrono::steady_clock::now() > until) {
      std::fprintf(stderr, "nobody reads\n");
      return 1;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  std::mt19937 random(1);  // NOLINT: the same numbers in each run
  std::vector<std::uint16_t> pixels(kWidth * kHeight);
  const std::vector<std::uint8_t> received(pixels.size(), 7);
  for (std::uint32_t number = 0; number < count; ++number) {
    for (std::uint16_t& pixel : pixels) {
      pixel = static_cast<std::uint16_t>(random());
    }
    client::Frame frame{.origin = {.device_id = 1, .session_id = 2}, .stamp = {.number = number}};
    frame.depth = frame.interval_width = {pixels.data(), kWidth, kHeight};
    frame.received = {received.data(), kWidth, kHeight};
    frame.calibration = wire::CalibrationPacket{.image_width = kWidth,
                                                .image_height = kHeight,
                                                .fx = 65536,
                                                .fy = 65536,
                                                .depth_unit_um = 250};
    const std::int64_t time = 1'000'000'000 + std::int64_t{number} * 33'000'000;
    feed.show(frame, {.first_packet_ns = time});
    feed.tell({.health = wire::HealthReport{.uptime_ms = number, .active = number}}, time);
    feed.place_frames(time);
    if (!publisher.drain(kPatience)) {
      std::fprintf(stderr, "nobody acknowledges\n");
      return 1;
    }
  }
  return 0;
}

}  // namespace
}  // namespace stof

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "bridge_sample DOMAIN NAMESPACE COUNT\n");
    return 2;
  }
  auto publisher =
      stof::bridge::Publisher::open({.domain = stof::number_of(argv[1]), .name_space = argv[2]});
  if (!publisher) {
    std::fprintf(stderr, "%s\n", publisher.error().c_str());
    return 2;
  }
  return stof::publish(*publisher, argv[2], stof::number_of(argv[3]));
}
