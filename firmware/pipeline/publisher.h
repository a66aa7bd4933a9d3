#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "dsp/base/arena.h"
#include "firmware/control/receiver_list.h"
#include "firmware/events/events.h"
#include "firmware/events/health_monitor.h"
#include "firmware/pipeline/frame_listener.h"
#include "firmware/pipeline/pipeline.h"
#include "firmware/pipeline/raw_sender.h"
#include "firmware/pipeline/receiver_way.h"
#include "firmware/pipeline/shot.h"
#include "firmware/wire/calibration/calibration_packet.h"
#include "firmware/wire/frame/frame_coder.h"
#include "hal/clock.h"
#include "hal/datagram_port.h"

namespace stof::firmware {

// The sender, as every receiver has to know it.
struct PublisherSetup {
  wire::Origin origin;
  wire::ClockState clock = wire::ClockState::kMonotonic;
  wire::CalibrationPacket calibration{};
};

// May change between frames.
struct PublisherParams {
  wire::StreamChoice choice{};
  int pace_percent = 60;          // of the period: frames are spread over at most that; 0: at once
  hal::Duration period{};         // of the trigger
  std::uint32_t revision = 0;     // of the settings
  std::uint32_t fingerprint = 0;  // of them
  std::uint32_t blinding = 0;     // by them: HealthMonitor::Blindness, the sum
  int pmd_every = 1;              // of the trigger's edges; sent with raw pictures, as the next
  int disparities = 0;            // that are searched
  dsp::QuarterMm max_range = 0;   // sent with the calibration, as the period; 0: as at start
};

// The times of a frame's way out.
struct PublisherTimes {
  hal::Duration code{};
  hal::Duration send{};    // without the waits of pacing
  hal::Duration waited{};  // these
};

// Depth maps to datagrams, to all receivers alike, but for the signatures of those who asked for
// them; health and events beside them.
class Publisher {
 public:
  // Datagrams that are signed at once, for all receivers together: between two bursts the processor
  // forgets the code, so that 8 at a time take a third longer each.
  static constexpr std::size_t kSignedAtOnce = 64;

  // listener may be nullptr.
  Publisher(const PublisherSetup& setup, const wire::FrameSizes& sizes, hal::Clock& clock,
            hal::DatagramPort& port, FrameListener* listener, Events& events,
            dsp::Arena& arena) noexcept;
  Publisher(const Publisher&) = delete;
  Publisher& operator=(const Publisher&) = delete;

  void set_params(const PublisherParams& params) noexcept;
  // Of the frames from now on, with pictures of the same sizes; receivers get it before the first.
  void set_calibration(const wire::CalibrationPacket& calibration) noexcept;
  // The receivers from now on; a new one gets calibration and health at once. True: raw pictures
  // are asked for anew, from a state that begins anew (wire::kRawAnew).
  bool set_receivers(const ReceiverList& receivers) noexcept;

  // Sends one frame, paced so that it ends at `latest` at most, or at once when that has passed.
  // Counts packets. Never blocks longer than until `latest`, nor longer than 50 ms; a frame that
  // became old meanwhile, as the program stood still, is abandoned. kWouldBlock: some were dropped.
  // kDeviceError: no receiver can be reached. kDeviceLost: reopen.
  Status publish(const Shot& shot, const Output& output, hal::Time latest) noexcept;
  // A shot whose frame was published, and that nobody needs any more: its pictures go, in time that
  // is left, to a receiver that asked for them. Those of the shot before that are still on their
  // way go first, and at once, until `until`.
  void offer_raw(Shot& shot, hal::Time until = {}) noexcept;
  // Waits, and sends raw pictures meanwhile: what the loop does until an edge.
  void wait_until(hal::Time time) noexcept;
  // What is lent of raw pictures goes home: a camera is to be opened again.
  void give_back_raw(bool pair, bool samples) noexcept { raw_.give_back(pair, samples); }
  // Events that are due: as soon as one may have been noted.
  void report_events() noexcept;
  // Health, and events that are due. Each period, also where there is no frame.
  void report(const ControlStatus& control) noexcept;

  // The times of the last frame.
  const PublisherTimes& times() const noexcept { return times_; }
  HealthMonitor& health() noexcept { return health_; }
  const HealthMonitor& health() const noexcept { return health_; }

 private:
  using Datagrams = wire::Datagrams;
  class Paced;  // a frame's datagrams on their way, spread over time
  class RawWay;

  Sensors rig_sensors() const noexcept;
  hal::Duration latency(const Shot& shot, hal::Time now) const noexcept;
  wire::FrameInfo describe(const Shot& shot, const Output& output) const noexcept;
  wire::Header header(wire::PacketType type) const noexcept;
  Status send_frame(const Shot& shot, const Output& output, const wire::FrameInfo& info,
                    hal::Time latest) noexcept;
  hal::Duration longest_sending() const noexcept;
  void drop(std::size_t datagrams) noexcept;
  // Of one receiver: what became of them.
  struct Delivery {
    bool reached = false;  // it can be
    bool dropped = false;  // some of them
    bool lost = false;     // the port
    std::size_t left = 0;  // that were not tried then
  };
  // Signs the first of them for whoever wants that, as many as there is space for: their number.
  // They are what send() sends until the next call.
  std::size_t prepare(Datagrams datagrams) noexcept;
  // Some of what is prepared to everybody, now.
  Status send(std::size_t first, std::size_t count) noexcept;
  // Sends what buffer_ holds of a packet.
  void tell(wire::PacketType type, std::size_t bytes) noexcept;
  Delivery deliver(std::size_t receiver, Datagrams datagrams) noexcept;
  Status send_raw(Datagrams datagrams, std::size_t& sent) noexcept;
  Status send_one(std::span<const std::byte> datagram) noexcept;

  PublisherSetup setup_;
  hal::Clock& clock_;
  hal::DatagramPort& port_;
  FrameListener* listener_;
  Events& events_;
  wire::FrameCoder coder_;
  PublisherParams params_;
  HealthMonitor health_;
  ReceiverList receivers_;
  RawSender raw_;
  std::array<ReceiverWay, kMostSubscribers> ways_{};
  std::optional<wire::FrameStamp> stamp_;  // of the last frame
  std::optional<hal::Time> calibration_due_;
  bool health_wanted_ = true;  // health for a new receiver
  PublisherTimes times_;
  wire::DatagramBuffer buffer_{};
  std::span<wire::DatagramBuffer> signed_space_;
  std::span<wire::DatagramBuffer> signed_raw_;  // RawSender::kBurst of them
  std::array<std::span<const std::byte>, kSignedAtOnce> signed_{};
};

}  // namespace stof::firmware
