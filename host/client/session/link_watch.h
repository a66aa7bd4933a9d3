#pragma once

#include <cstdint>
#include <optional>

#include "host/client/frame/frame.h"
#include "host/client/reassembler.h"

namespace stof::client {

// What a receiver knows of its sensor by its own clock, whatever the sensor says, and how old what
// it tells is. An age counts from the arrival at this machine; none: there is none yet. For the age
// of what a frame shows add FrameInfo::latency_ns, from the exposure to the sending.
struct LinkState {
  // No frame for three periods and 20 ms; 500 ms as long as the period is not known. The period is
  // that of Reassembler::period(): what the sensor tells, as far as frames bear it out.
  bool silent = true;
  // The sensor started again: for a second, and until the first frame after that start.
  bool restarted = false;
  // Within the last 2 seconds something came that no sensor can have sent in its place, or that is
  // not signed where it has to be: somebody speaks in the sensor's name, or it is faulty. What it
  // said was not believed.
  bool forged_traffic = false;
  // Within the last 2 seconds frames came so much later than others before that they were not
  // delivered: the network is too slow, or somebody holds them back.
  bool delayed = false;
  // Whoever answers says that the sensor knows none of the keys that sign the subscription: they
  // were ended, or somebody makes it up.
  bool no_key = false;

  std::optional<Duration> frame_age{};  // of the last packet of the newest frame delivered
  std::optional<Duration> health_age{};
  std::optional<Duration> calibration_age{};
};

// No frame for so long is a silence. period: as Reassembler::period(); 0: not known.
Duration silence_after(Duration period) noexcept;

// Keeps what LinkState is made of.
class LinkWatch {
 public:
  static constexpr Duration kRestartTold = std::chrono::seconds(1);
  static constexpr Duration kForgeryTold = std::chrono::seconds(2);
  static constexpr Duration kLateTold = std::chrono::seconds(2);

  explicit LinkWatch(Time opened) noexcept : heard_(opened) {}

  // Datagrams were pushed, and frames taken, until `now`.
  void look(const Reassembler& reassembler, Time now) noexcept;
  void delivered(const Frame& frame) noexcept;
  // Something of its streams came that the sensor does not send us.
  void uninvited(Time now) noexcept { forged_at_ = now; }
  // Whether the newest answer says that no key of ours is known.
  void keys_refused(bool refused) noexcept { keys_refused_ = refused; }

  LinkState state(Time now) const noexcept;

 private:
  Time heard_;  // the newest frame, before it: when we began
  std::optional<Time> frame_at_;
  std::optional<Time> health_at_;
  std::optional<Time> calibration_at_;
  std::optional<Time> restarted_at_;
  std::optional<Time> forged_at_;
  std::optional<Time> late_at_;
  Duration period_{0};  // 0: not known
  std::uint64_t sessions_ = 0;
  std::uint64_t forgeries_ = 0;
  std::uint64_t late_ = 0;
  bool keys_refused_ = false;
};

}  // namespace stof::client
