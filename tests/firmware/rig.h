#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "board/board.h"
#include "firmware/events/events.h"
#include "firmware/loop/loop.h"
#include "firmware/pipeline/pipeline.h"
#include "firmware/pipeline/publisher.h"
#include "hal/emu/cameras/pmd_camera.h"
#include "hal/emu/cameras/stereo_camera.h"
#include "hal/emu/cameras/trigger.h"
#include "hal/emu/devices/clock.h"
#include "hal/emu/devices/datagram_port.h"
#include "hal/emu/devices/faults.h"
#include "hal/emu/imagery/imagery.h"
#include "tests/support/guarded_memory.h"

// A small rig of emulated devices around the real loop, and a receiver that looks at its packets.
namespace stof::firmware::test {

namespace emu = hal::emu;
using namespace std::chrono_literals;

inline constexpr int kWidth = 32;
inline constexpr int kHeight = 24;
inline constexpr int kPmdWidth = 16;
inline constexpr int kPmdHeight = 12;
inline constexpr int kDisparities = 8;
inline constexpr double kFocal = 40;      // px
inline constexpr double kBaseline = 0.1;  // m: 4 m px

inline board::TimingConfig timing() {
  return {.period = 33ms,
          .stereo_exposure = 4ms,
          .pmd_integration = 16ms,
          .edge_tolerance = 200us,
          .pmd_every = 1};
}

// Every edge shows a wall at its own distance, with its own texture.
int disparity_of(std::size_t edge);
double depth_of(std::size_t edge);

// Writes down the edges that the cameras saw.
class EdgeLog final : public emu::EdgeListener {
 public:
  explicit EdgeLog(bool still = false) : still_(still) {}
  void on_edge(hal::Time edge) noexcept override { edges.push_back(edge); }
  std::optional<std::size_t> find(hal::Time edge) const noexcept;
  // What stands before the cameras at that edge; an unknown one shows the first edge's.
  std::size_t scene(hal::Time edge) const noexcept { return still_ ? 0 : find(edge).value_or(0); }
  // How far away the PMD camera measures it, m.
  double pmd_depth(hal::Time edge) const noexcept;

  std::vector<hal::Time> edges;

 private:
  bool still_;
};

class NoImagery final : public emu::Imagery {
 public:
  emu::Size stereo_size() const noexcept override { return {kWidth, kHeight}; }
  emu::Size pmd_size() const noexcept override { return {kPmdWidth, kPmdHeight}; }
  void left(std::uint32_t, dsp::ImageView<std::uint8_t>) noexcept override {}
  void right(std::uint32_t, dsp::ImageView<std::uint8_t>) noexcept override {}
  void pmd(std::uint32_t, int, dsp::ImageView<std::uint16_t>) noexcept override {}
};

// Edges at which a sensor's pixels are not those of its exposure, whatever its stamps say.
struct PixelFault {
  std::size_t first = 0;
  std::size_t edges = 0;
  bool dark = false;  // black, or samples without light; else those of the edge before the first
  const std::atomic<std::size_t>* since = nullptr;  // the first edge, where that changes

  std::size_t begin() const noexcept { return since == nullptr ? first : since->load(); }
  bool strikes(std::size_t edge) const noexcept {
    return edge >= begin() && edge - begin() < edges;
  }
  std::size_t shown(std::size_t edge) const noexcept { return strikes(edge) ? begin() - 1 : edge; }
};

struct PixelFaults {
  PixelFault left{};
  PixelFault right{};
  PixelFault pmd{};
};

// Paint into each view what stood before the cameras at the edge that the view's own stamp names:
// a depth map made of views from different edges shows it. Also write down the deadlines they get.
class PaintedStereo final : public hal::StereoCamera {
 public:
  PaintedStereo(hal::StereoCamera& camera, const EdgeLog& log, const PixelFaults& faults)
      : camera_(camera), log_(log), faults_(faults) {}
  Result<hal::BorrowedFrame<hal::StereoFrame>> wait_frame(hal::Time deadline) noexcept override;

  hal::Time latest_deadline{};

 private:
  hal::StereoCamera& camera_;
  const EdgeLog& log_;
  PixelFaults faults_;
};

class PaintedPmd final : public hal::PmdCamera {
 public:
  PaintedPmd(hal::PmdCamera& camera, const EdgeLog& log, hal::Duration integration,
             const PixelFaults& faults)
      : camera_(camera), log_(log), integration_(integration), fault_(faults.pmd) {}
  Result<hal::BorrowedFrame<hal::PmdFrame>> wait_frame(hal::Time deadline) noexcept override;

  hal::Time latest_deadline{};

 private:
  hal::PmdCamera& camera_;
  const EdgeLog& log_;
  hal::Duration integration_;
  PixelFault fault_;
};

class NoNetwork final : public hal::NetworkInterfaces {
 public:
  std::size_t addresses(std::span<hal::InterfaceAddress>) noexcept override { return 0; }
};

struct Faults {
  emu::FaultPlan trigger{};
  emu::FaultPlan stereo{};
  emu::FaultPlan pmd{};
  emu::FaultPlan link{};
};

struct RigOptions {
  Faults faults{};
  PixelFaults pixels{};
  board::TimingConfig timing = test::timing();
  bool with_pmd = true;
  hal::DatagramPort* port = nullptr;  // in place of the emulated one
  wire::StreamChoice choice{.coding = {wire::Coding::kRaw, wire::Coding::kRaw, wire::Coding::kRaw}};
  dsp::ThreadTeam threads = {};  // that compute
  bool still = false;  // every edge shows the first one's wall, the PMD camera's noise is its own
  bool temporal = false;  // depth is averaged over frames
  DeviceLending* lending = nullptr;
  bool require_both = false;  // no frame without one of the sensors
};

Setup small_setup(bool with_pmd);

// A member for each device and each part of the appliance: what is above depends on none below.
struct Rig {
  explicit Rig(const RigOptions& options = {});
  Rig(const Rig&) = delete;
  Rig& operator=(const Rig&) = delete;

  emu::Clock clock;
  NoImagery imagery;
  EdgeLog log;
  emu::StereoCamera stereo;
  emu::PmdCamera pmd;
  PaintedStereo painted_stereo;
  PaintedPmd painted_pmd;
  emu::Trigger trigger;
  emu::DatagramPort port;
  NoNetwork network;
  board::Board board;
  Setup setup;
  stof::test::GuardedBuffer<std::byte> memory;
  dsp::Arena arena;
  Pipeline pipeline;
  Events events;
  Publisher publisher;
  Loop loop;
};

// A frame put together again from its packets.
struct Received {
  wire::FrameStamp stamp;
  wire::FrameInfo info;
  std::vector<std::uint16_t> depth;
  std::vector<std::uint8_t> source;
  std::size_t packets = 0;

  bool complete() const {
    return packets == std::size_t{1} + info.tiles[0] + info.tiles[1] + info.tiles[2];
  }
  std::size_t count(dsp::Source which) const;
  // The median of the pixels of that source, in metres; 0 without any.
  double depth_m(dsp::Source of = dsp::Source::kBoth) const;
};

class Receiver {
 public:
  // Takes everything that waits in the link.
  void drain(emu::DatagramPort& port);

  std::map<std::uint32_t, Received> frames;  // by number
  std::size_t calibrations = 0;
  std::vector<wire::EventReport> events;
  std::vector<wire::HealthReport> healths;
  std::size_t damaged = 0;
  std::vector<std::byte> bytes;  // all datagrams, one after the other

 private:
  void take(const wire::PacketView& packet);
};

// Runs `steps` periods.
void run(Rig& rig, Receiver& receiver, int steps);

// That every complete frame came from one edge, each from a later one than the frame before it, and
// shows what the sensors that it names saw there. Returns the edges, in order.
std::vector<std::size_t> expect_true_frames(const Rig& rig, const Receiver& receiver);

}  // namespace stof::firmware::test
