#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "board/board.h"
#include "dsp/base/arena.h"
#include "dsp/base/thread_team.h"
#include "firmware/control/receiver_list.h"
#include "firmware/events/events.h"
#include "firmware/loop/loop.h"
#include "firmware/loop/standby.h"
#include "firmware/pipeline/pipeline.h"
#include "firmware/pipeline/publisher.h"
#include "firmware/program/run_config.h"
#include "firmware/serial/line/byte_ring.h"
#include "firmware/serial/serial_sender.h"
#include "firmware/spsc_ring.h"

namespace stof::firmware {

// New settings, from the control thread to the loop's.
using RunConfigRing = SpscRing<RunConfig, 4>;

// Memory that begins aligned for Arena.
struct Memory {
  std::span<std::byte> images;  // for the pipeline of every RunConfig that will come
  std::span<std::byte> coded;   // for coded frames and the serial line's pictures
};

// The parts on the loop's thread: pipeline, publisher and loop, in the workspace; other threads
// help with the pipeline alone. New settings take effect between two frames: those of the publisher
// from the next one on; a new way to compute depth builds the pipeline anew in the same memory.
// Allocates nothing after construction.
class Appliance {
 public:
  struct Parts {
    board::Board& board;
    Events& events;
    RunConfigRing& run_configs;
    ReceiverRing& receivers;
    ByteRing* serial;                  // to the serial line; nullptr: there is none
    dsp::ThreadTeam threads;           // that may compute, the loop's among them
    ChangeRing* changes = nullptr;     // that clients made; nullptr: nobody can
    DeviceLending* lending = nullptr;  // of lost devices; nullptr: they come back by themselves
  };

  Appliance(const Parts& parts, const PublisherSetup& publisher, const RunConfig& run_config,
            const Memory& memory) noexcept;
  Appliance(const Appliance&) = delete;
  Appliance& operator=(const Appliance&) = delete;

  // New receivers and settings, then a period, Loop::step(), or, where the next edge is far, a part
  // of the wait for it; in standby a part of that. Health and events.
  Status step(const ControlStatus& control) noexcept;

  // As Loop::end_after().
  void end_after(std::uint64_t frames) noexcept { loop_->end_after(frames); }

  // As if Parts::run_configs had brought it: takes effect before the next step().
  void apply(const RunConfig& run_config) noexcept;
  // Builds the pipeline anew: nothing of the frames before counts for the next.
  void begin_anew() noexcept;

  const Publisher& publisher() const noexcept { return publisher_; }
  // RunConfig::installs of the configuration that frames are made with.
  std::uint32_t installs() const noexcept { return run_config_.installs; }
  bool in_standby() const noexcept { return standby_.active(); }
  SerialSender::Counters serial() const noexcept {
    return serial_ ? serial_->sender.counters() : SerialSender::Counters{};
  }

 private:
  // The serial line as the publisher sees it.
  class SerialListener final : public FrameListener {
   public:
    SerialListener(const SerialSetup& setup, ByteRing& ring, hal::Clock& clock,
                   dsp::Arena& arena) noexcept
        : clock_(clock), sender(setup, ring, arena) {}
    void frame(const wire::FrameStamp& stamp, const wire::FrameInfo& info,
               const dsp::DepthMap& map) noexcept override {
      sender.frame(stamp, info, map, clock_.now());
    }
    void packet(std::span<const std::byte> datagram) noexcept override {
      sender.put(datagram, clock_.now());
    }

   private:
    hal::Clock& clock_;

   public:
    SerialSender sender;
  };

  void note(Event event) noexcept;
  void note_changes(const ControlStatus& control) noexcept;
  void update_standby(const ControlStatus& control, hal::Time now) noexcept;
  void build(const RunConfig& run_config) noexcept;

  Parts parts_;
  RunConfig run_config_;
  dsp::Arena arena_;
  std::optional<SerialListener> serial_;
  Publisher publisher_;
  std::span<std::byte> images_;
  std::optional<Pipeline> pipeline_;
  std::optional<Loop> loop_;
  std::uint32_t release_ = kNoRelease;
  Standby standby_;
  bool receiving_ = false;               // there are receivers
  bool anew_wanted_ = false;             // a receiver of raw pictures asked for it
  std::optional<hal::Time> begun_anew_;  // for the last time because of that
};

}  // namespace stof::firmware
