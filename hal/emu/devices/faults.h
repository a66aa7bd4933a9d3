#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <limits>

#include "dsp/base/check.h"
#include "hal/time.h"

namespace stof::hal::emu {

// Kinds of faults. A call is: for a camera an edge at which it would expose, for the trigger a
// pulse(), for the port each datagram that is sent.
//
//           camera                          trigger                     port
// kDrop     the exposure never arrives      pulse() is fine, but no     lost without a word
//                                           camera saw the edge
// kDelay    it arrives `duration` later,    the edge goes out           delivered after the
//           with its true stamps, and so    `duration` later; the       next that is sent
//           do those behind it              returned time is true
// kRepeat   the last frame that arrived     a second edge follows       delivered twice
//           comes again in its place, with  `duration` later, unseen
//           its old stamps and sequence     by the caller
// kTear     stereo: the right view is the   the edge goes out, its      cut to half its length, one
//           previous exposure's; PMD: A2    time is lost:               byte changed
//           and A3 are. The stamps say so   kDeviceError
// kCorrupt  the adapter sees the damage:    no edge goes out:           one byte changed
//           wait_frame returns kCorrupt     kDeviceError
// kVanish   no exposure; all that waited    no edge: kDeviceLost        not taken: kDeviceError
//           is gone: kDeviceLost until an
//           edge without this fault
// kFreeze   the pixels of the frame that    none                        none
//           arrived before, under the
//           stamps and numbers of this one;
//           stereo: in the right view alone
// kDark     PMD: the lamp gives no light    none                        none
// kHang     as kFreeze, but ends where the  none                        none
//           camera is opened again
enum class FaultKind : std::uint8_t {
  kNone,
  kDrop,
  kDelay,
  kRepeat,
  kTear,
  kCorrupt,
  kVanish,
  kFreeze,
  kDark,
  kHang
};
inline constexpr std::array kAllFaultKinds{
    FaultKind::kDrop,   FaultKind::kDelay,   FaultKind::kRepeat,
    FaultKind::kTear,   FaultKind::kCorrupt, FaultKind::kVanish,
    FaultKind::kFreeze, FaultKind::kDark,    FaultKind::kHang};

// How much later an exposure comes, or an edge, where nobody says otherwise.
inline constexpr Duration kUsualFaultDuration = std::chrono::milliseconds(25);

struct Fault {
  static constexpr std::uint32_t kForever = std::numeric_limits<std::uint32_t>::max();

  FaultKind kind = FaultKind::kNone;
  std::uint32_t call = 0;   // the first call it strikes, counted from 0
  std::uint32_t calls = 1;  // so many in a row; kForever: from there on
  std::uint32_t every = 0;  // and again after every so many calls; 0: not again
  Duration duration{};      // of kDelay; of kRepeat on the trigger

  constexpr bool strikes(std::uint32_t at) const noexcept {
    if (at < call) {
      return false;
    }
    const std::uint32_t since = every == 0 ? at - call : (at - call) % every;
    return calls == kForever || since < calls;
  }
};

// The faults of one device and the calls at which they strike; a fixed small list, the first entry
// that strikes counts. Empty: nothing ever does.
class FaultPlan {
 public:
  static constexpr std::size_t kMaxFaults = 8;

  constexpr FaultPlan() noexcept = default;
  constexpr FaultPlan(std::initializer_list<Fault> faults) noexcept {
    for (const Fault& fault : faults) {
      STOF_CHECK(add(fault));
    }
  }

  // One more; where two strike at a call, the first counts. false: there are kMaxFaults.
  [[nodiscard]] constexpr bool add(const Fault& fault) noexcept {
    if (count_ == kMaxFaults) {
      return false;
    }
    faults_[count_++] = fault;
    return true;
  }

  constexpr bool empty() const noexcept { return count_ == 0; }
  constexpr Fault at(std::uint32_t call) const noexcept {
    for (std::size_t i = 0; i < count_; ++i) {
      if (faults_[i].strikes(call)) {
        return faults_[i];
      }
    }
    return {};
  }

 private:
  std::array<Fault, kMaxFaults> faults_{};
  std::size_t count_ = 0;
};

}  // namespace stof::hal::emu
