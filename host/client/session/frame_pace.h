#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "host/client/frame/frame.h"
#include "host/client/frame/made_with.h"

namespace stof::client {

// How far apart frames come, and which of the periods to believe that are told in a sensor's name:
// of a sensor whose frames tell theirs, these alone; of an older one, those of its messages.
//  - The shortest one of the last seconds in which frames came. The sensor tells its own once a
//    second, or with each frame where those are rarer, so a longer one that somebody else tells
//    makes nobody wait longer for the next frame, whatever gaps he makes between frames.
//  - Never a longer one than frames have come apart, and never a much shorter one than they do.
// What was told of frames with other settings, or before a start, holds for these alone.
// No clock: times are the caller's.
class FramePace {
 public:
  // Before its second frame no more is believed.
  static constexpr Duration kUnproven = std::chrono::seconds(1);

  // A frame that is newer than all before; made: nothing: its info did not arrive.
  void note(Time arrived, const std::optional<MadeWith>& made) noexcept;
  // Frames were refused since, or their order is begun anew: the gap to the next one counts for
  // nothing.
  void interrupt() noexcept { interrupted_ = true; }
  // A calibration message tells this period; 0: none.
  void tell(Duration period) noexcept;

  // The period to go by; 0: none was told.
  Duration believed() const noexcept;
  // The newest that was told, for whoever knows that the sensor told it.
  Duration told() const noexcept { return newest_told_; }

 private:
  // More than frames that a stalled network or reader gets at once.
  static constexpr std::size_t kGaps = 32;
  // Seconds in which frames came, this one and those before.
  static constexpr std::size_t kSeconds = 4;

  struct Second {
    std::int64_t number = -1;
    Duration least{0};  // that was told in it
  };
  struct Told {
    std::optional<MadeWith> made;
    std::array<Second, kSeconds> seconds;
  };

  void change_to(const MadeWith& made) noexcept;
  void take(Duration period, Told& told_of) noexcept;
  // Below this nothing is believed.
  Duration least() const noexcept;
  std::int64_t second() const noexcept { return came_ / std::chrono::seconds(1); }

  std::optional<Time> newest_;
  bool interrupted_ = false;
  std::array<Duration, kGaps> gaps_{};  // the newest ones; 0: none yet
  std::size_t noted_ = 0;               // ever
  Duration came_{0};                    // of each gap a second at most
  Duration newest_told_{0};
  bool frames_tell_ = false;
  Told current_;
  Told former_;  // of the frames before: one forged frame forgets nothing
};

}  // namespace stof::client
