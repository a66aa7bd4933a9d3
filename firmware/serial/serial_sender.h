#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/fusion/depth_map.h"
#include "firmware/serial/line/byte_ring.h"
#include "firmware/serial/line/line_budget.h"
#include "firmware/serial/mavlink/mavlink.h"
#include "firmware/serial/picture_profile.h"
#include "firmware/serial/sector_finder.h"
#include "firmware/serial/serial_params.h"
#include "firmware/wire/frame/frame_coder.h"
#include "firmware/wire/messages/calibration.h"
#include "firmware/wire/messages/frame_info.h"
#include "firmware/wire/packet.h"
#include "hal/time.h"

namespace stof::firmware {

struct SerialSetup {
  wire::Origin origin;
  wire::CalibrationPacket calibration;  // of the whole depth map
  wire::ClockState clock = wire::ClockState::kMonotonic;
};

// The loop's side of the serial line: decides what goes, makes it, puts it into the ring. Nothing
// blocks; no heap. Frames that the ring or the line does not take are dropped and counted, whole
// ones only.
//
// Never more than the line carries: a frame waits until what was sent before needs less than half
// an interval of the rate. Whatever is newest then goes.
class SerialSender {
 public:
  // Holds the largest frame of all profiles.
  static constexpr std::size_t kRingBytes = std::size_t{1} << 17;

  struct Counters {
    std::uint64_t sent = 0;  // frames and messages that the ring took
    std::uint64_t dropped = 0;
  };

  SerialSender(const SerialSetup& setup, ByteRing& ring, dsp::Arena& arena) noexcept;

  // From the next frame on; of the same sizes.
  void set_calibration(const wire::CalibrationPacket& calibration) noexcept;
  // From the next frame on.
  void set(const SerialParams& params) noexcept;
  // Something that was computed at `now`. `stamp` and `info` as for the other link; frames on this
  // line are numbered on their own. The map has the size of the setup's calibration.
  void frame(const wire::FrameStamp& stamp, const wire::FrameInfo& info, const dsp::DepthMap& map,
             hal::Time now) noexcept;
  // Every period, also while there are no frames: MAVLink's heartbeat.
  void tick(hal::Time now, wire::Health health) noexcept;
  // A sealed packet that goes whatever the rate: health, event. Not with MAVLink.
  void put(std::span<const std::byte> packet, hal::Time now) noexcept;

  const Counters& counters() const noexcept { return counters_; }

 private:
  using Records = std::span<const std::span<const std::byte>>;

  bool due(hal::Time now) noexcept;
  hal::Duration interval() const noexcept;
  // Whether the ring took all of them.
  bool push(Records records, hal::Time now) noexcept;
  bool send_picture(const wire::FrameStamp& stamp, const wire::FrameInfo& info,
                    const dsp::DepthMap& map, hal::Time now) noexcept;
  bool send_calibration(const wire::FrameStamp& stamp, const wire::FrameInfo& info,
                        const PictureProfile& profile, hal::Time now) noexcept;
  bool send_sectors(const Sectors& sectors, const wire::FrameStamp& stamp, hal::Time now) noexcept;
  bool send_mavlink(const Sectors& sectors, const wire::FrameStamp& stamp, hal::Time now) noexcept;

  SerialSetup setup_;
  ByteRing& ring_;
  SerialParams params_;
  LineBudget budget_;
  SectorFinder finder_;
  wire::FrameCoder coder_;
  dsp::DepthMap picture_;  // decimated: depth and width
  mavlink::Writer mavlink_;
  wire::DatagramBuffer packet_{};
  std::uint32_t number_ = 0;
  std::optional<hal::Time> next_;  // when the next frame is due
  bool blocked_ = false;           // it was due already
  std::optional<hal::Time> next_calibration_;
  std::optional<hal::Time> next_heartbeat_;
  Counters counters_;
};

}  // namespace stof::firmware
