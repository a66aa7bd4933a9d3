#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "firmware/wire/messages/calibration.h"
#include "host/client/frame/frame.h"
#include "host/client/frame/image_size.h"
#include "host/client/frame/made_with.h"

namespace stof::client {

// The calibrations that were told in a sensor's name, and which of them is believed. A fingerprint
// is that of a file: under one of them, and of one image size, no sensor ever tells two lenses. So
// where it happens, somebody lies:
//  - A lens that was alone from the first on for 3 seconds and 3 frames that name it stands. What
//    contradicts it is refused, however often it comes, unless it comes for 10 seconds and 10 such
//    frames, and the known one not once.
//  - Before that nobody can say which of the two is the lie: neither is believed, until one of them
//    was alone for 3 seconds and 3 frames; after 10 of both it stands. Frames have no lens so long.
// A sensor sends its own once a second, or with each frame where those are rarer. What was learned
// outlasts a start that the sensor itself told, for a fingerprint does. Where a fingerprint is
// not told (0) all is believed. Other image sizes than frames have push nothing out.
// Range and period are the settings', and change under one fingerprint: they are those that frames
// tell of themselves, and those of messages only where frames tell none.
// No clock: times are the caller's.
class LensBook {
 public:
  static constexpr Duration kBelievedAfter = std::chrono::seconds(3);
  static constexpr std::uint64_t kBelievedFrames = 3;
  static constexpr Duration kStandsAfter = std::chrono::seconds(10);
  static constexpr std::uint64_t kStandsFrames = 10;

  // units_change: the unit of depth is no part of a lens. On a serial line one picture takes the
  // place of another of the same size.
  explicit LensBook(bool units_change = false) noexcept : units_change_(units_change) {}

  // A session begins: none was told in it. outlasts: what was learned before it; else that may be
  // of somebody else, and nothing is known.
  void restart(bool outlasts) noexcept;

  // One that arrived then; false: it contradicts another. late: one that was sent after it arrived
  // before, it changes nothing of period and range.
  bool take(const wire::CalibrationPacket& told, Time arrived, bool late) noexcept;
  // A frame arrived then that was made so; depth: the size of its depth.
  void note_frame(const MadeWith& made, ImageSize depth, Time arrived) noexcept;

  // Of frames as they come now: one with the fingerprint that the newest frame names; before the
  // first frame, and where that names none, any. Of several one that stands, of these the newest.
  // None: not told in this session, or in doubt.
  std::optional<wire::CalibrationPacket> current() const noexcept;
  // Of a frame with depth of this size (0: it has none) that was made so. One whose frame info is
  // missing goes with the frame before, where nothing else was told meanwhile.
  std::optional<wire::CalibrationPacket> of(const std::optional<MadeWith>& made,
                                            ImageSize depth) const noexcept;

 private:
  // More than a sensor has pictures on a line. Those that stand are kept, and of the others the
  // ones that frames named last.
  static constexpr std::size_t kEntries = 8;

  // How long nothing contradicted.
  struct Alone {
    Time since;
    std::uint64_t frames = 0;  // that had named the fingerprint by then
  };
  struct Rival {
    wire::CalibrationPacket lens;
    Alone alone;
  };
  struct Entry {
    wire::CalibrationPacket lens;
    Alone alone;
    std::uint64_t frames = 0;  // of its size, that named it
    std::uint64_t named = 0;   // the order of the newest of them; 0: none
    std::uint64_t told = 0;    // the order of its newest message in this session; 0: none
    bool doubted = false;
    bool ever_doubted = false;
    bool stands = false;
    std::optional<Rival> rival = std::nullopt;  // since it came last
  };

  bool same(const wire::CalibrationPacket& one,
            const wire::CalibrationPacket& other) const noexcept;
  bool take_again(Entry& entry, const wire::CalibrationPacket& told, Time arrived,
                  bool late) noexcept;
  bool take_other(Entry& entry, const wire::CalibrationPacket& told, Time arrived) noexcept;
  std::optional<Entry>& place(const wire::CalibrationPacket& told) noexcept;
  std::uint32_t last_told() const noexcept;  // the fingerprint
  template <typename Accepts>
  const wire::CalibrationPacket* newest(Accepts accepts) const noexcept;

  bool units_change_;
  std::array<std::optional<Entry>, kEntries> entries_;
  std::uint64_t told_ = 0;        // messages, ever
  std::uint64_t frames_ = 0;      // that named anything, ever
  std::optional<MadeWith> made_;  // the newest frame of the session
};

}  // namespace stof::client
