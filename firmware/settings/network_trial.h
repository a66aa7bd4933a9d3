#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <optional>
#include <string_view>

#include "firmware/settings/settings.h"
#include "hal/store.h"
#include "hal/time.h"

namespace stof::settings {

// Hands network.* to the program that sets the machine's addresses, which stofd may not
// (board/image/network): a document of lines, "dhcp yes", "link_local no", "address A.B.C.D/BITS",
// "gateway A.B.C.D", "hostname NAME"; the last but one and two may be missing. When it has carried
// it out, that program leaves the same bytes in another document.
//
// A change of a running sensor is on trial, because who asked for it may not reach it any more: it
// is carried out as soon as its answer has left, and taken back where nobody confirms it in time.
// For the control thread; no heap.
class NetworkTrial {
 public:
  // For the answer to the request.
  static constexpr hal::Duration kAnswerTime = std::chrono::milliseconds(500);
  static constexpr hal::Duration kConfirmTime = std::chrono::seconds(60);

  NetworkTrial(hal::Store& wanted, hal::Store& done) noexcept : wanted_(wanted), done_(done) {}

  // What the start begins with: no trial. false: the document cannot be written.
  bool begin(const NetworkSettings& network) noexcept;
  // These are active from now on. The same as before is no change; what was confirmed last ends the
  // trial.
  void change(const NetworkSettings& next, hal::Time now) noexcept;
  // A change waits to be confirmed.
  bool runs() const noexcept { return until_.has_value(); }
  // What was asked for last has been carried out: whoever is heard over the network is heard by it.
  bool in_force() const noexcept { return !due_ && !pending_; }
  void confirm() noexcept;
  // What has to be active again, since nobody has confirmed the change in time; until change() gets
  // it.
  std::optional<NetworkSettings> tick(hal::Time now) noexcept;

 private:
  static constexpr std::size_t kDocumentBytes = 256;

  bool write() noexcept;
  bool is_done() noexcept;

  hal::Store& wanted_;
  hal::Store& done_;
  NetworkSettings active_{};
  NetworkSettings confirmed_{};
  std::optional<hal::Time> due_;    // it is to be written then
  std::optional<hal::Time> until_;  // it is to be confirmed
  bool pending_ = false;            // it is written, and not carried out
};

}  // namespace stof::settings
