#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <vector>

#include "firmware/pipeline/publisher.h"
#include "hal/emu/devices/clock.h"
#include "hal/emu/devices/datagram_port.h"
#include "tests/support/guarded_part.h"
#include "tests/support/random.h"

// What a publisher sends in tests, and one with a rig's memory around it.
namespace stof::firmware::test {

using namespace std::chrono_literals;
namespace emu = hal::emu;

inline constexpr wire::FrameSizes kSizes{
    .width = 160, .height = 90, .pmd_width = 40, .pmd_height = 30};
inline constexpr wire::CalibrationPacket kLens{
    .fx = 1 << 22, .fy = 1 << 22, .cx = 1 << 21, .cy = 1 << 21, .max_range = 40'000};
inline constexpr int kQueue = 1000;  // datagrams, more than a frame has

template <typename T>
class Noise {
 public:
  Noise(int width, int height, std::uint64_t seed, int most)
      : pixels_(static_cast<std::size_t>(width * height)), width_(width), height_(height) {
    stof::test::Random random(seed);
    for (T& pixel : pixels_) {
      pixel = static_cast<T>(random.between(0, most));
    }
  }
  dsp::ImageView<T> view() { return {pixels_.data(), width_, height_}; }

 private:
  std::vector<T> pixels_;
  int width_;
  int height_;
};

class NoOwner final : public hal::SlotOwner {
 public:
  void give_back(int) noexcept override {}
};

// One frame of noise: no codec makes it shorter.
struct Scene {
  explicit Scene(std::uint64_t seed, int w = kSizes.width, int h = kSizes.height)
      : depth(w, h, seed, 65'535),
        width(w, h, seed + 1, 65'535),
        source(w, h, seed + 2, 5),
        cause(w, h, seed + 3, 5),
        left(w, h, seed + 4, 255),
        right(w, h, seed + 5, 255),
        disparity_raw(w, h, seed + 6, 30'000),
        samples{noise(seed + 7), noise(seed + 8), noise(seed + 9), noise(seed + 10)},
        disparity(static_cast<std::size_t>(w * h)) {
    for (int i = 0; i < w * h; ++i) {
      disparity[static_cast<std::size_t>(i)].raw = disparity_raw.view().at(i % w, i / w);
    }
    output.map = {depth.view(), width.view(), source.view(), cause.view()};
    output.stereo.disparity = {disparity.data(), w, h};
    output.left = left.view();
    output.right = right.view();
    pmd.samples = {samples[0].view(), samples[1].view(), samples[2].view(), samples[3].view()};
  }
  Shot shot() {
    return {.edge = emu::Clock::kStart,
            .exposed = {},
            .stereo = hal::BorrowedFrame<hal::StereoFrame>(stereo, owner, 0),
            .pmd = hal::BorrowedFrame<hal::PmdFrame>(pmd, owner, 0),
            .pmd_exposed = hal::Time{}};
  }
  static Noise<std::uint16_t> noise(std::uint64_t seed) {
    return {kSizes.pmd_width, kSizes.pmd_height, seed, 4095};
  }
  wire::FrameImages images() {
    return {.map = output.map,
            .disparity = output.stereo.disparity,
            .pmd = pmd.samples,
            .left = output.left,
            .right = output.right};
  }

  Noise<dsp::QuarterMm> depth, width;
  Noise<dsp::Source> source;
  Noise<dsp::Cause> cause;
  Noise<std::uint8_t> left, right;
  Noise<std::int16_t> disparity_raw;
  std::array<Noise<std::uint16_t>, 4> samples;
  std::vector<dsp::Disparity> disparity;
  hal::StereoFrame stereo;
  hal::PmdFrame pmd;
  NoOwner owner;
  Output output;
};

inline wire::StreamChoice everything(wire::Coding coding, bool parity) {
  wire::StreamChoice choice{.parity = parity, .cloud_step = 2};
  choice.coding.fill(coding);
  return choice;
}

// At ports 1 to `count`.
inline ReceiverList receivers_at_ports(std::size_t count) {
  ReceiverList list{.count = count};
  for (std::size_t i = 0; i < count; ++i) {
    list.peers[i].port = static_cast<std::uint16_t>(i + 1);
  }
  return list;
}

// The publisher with the memory of the appliance, which holds the usual streams.
struct Sender {
  explicit Sender(const wire::StreamChoice& choice, int queue = kQueue,
                  const emu::FaultPlan& faults = {}, hal::DatagramPort* other = nullptr)
      : port(queue, faults), in_memory([&](dsp::Arena& arena) {
          return Publisher({.origin = {.device_id = 7, .session_id = 9}, .calibration = kLens},
                           kSizes, clock, other != nullptr ? *other : port, nullptr, events, arena);
        }) {
    publisher.set_params({.choice = choice, .period = 33ms});
    const hal::Peer receiver{.address = {}, .port = 1};
    publisher.set_receivers({.peers = {receiver}, .count = 1});
  }
  Status publish(Scene& scene) {
    return publisher.publish(scene.shot(), scene.output, clock.now() + 20ms);
  }

  emu::Clock clock;
  emu::DatagramPort port;
  Events events;
  stof::test::GuardedPart<Publisher> in_memory;
  Publisher& publisher = *in_memory;
};

inline wire::StreamKey numbered_stream_key(std::uint32_t number) {
  wire::StreamKey key{.number = number};
  key.secret.fill(static_cast<std::byte>(number));
  return key;
}

}  // namespace stof::firmware::test
