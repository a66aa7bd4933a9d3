#pragma once

#include <chrono>
#include <cstdint>
#include <utility>

#include "firmware/control/token_bucket.h"
#include "firmware/events/events.h"

namespace stof::firmware {

// Which events get a line in the log. Anybody may change some settings of an unpaired sensor, as
// often as he likes: of changes ten get one after a rest, then one a second, which counts the
// others.
class ChangeLines {
 public:
  // All but some changes. Events come in their order.
  bool take(const Event& event) noexcept {
    if (event.kind != EventKind::kSettingsChanged || lines_.take(event.at)) {
      return true;
    }
    ++untold_;
    return false;
  }
  // How many had none since this was called.
  std::uint64_t take_untold() noexcept { return std::exchange(untold_, 0); }

 private:
  static constexpr std::uint32_t kMost = 10;

  TokenBucket lines_{kMost, std::chrono::seconds(1)};
  std::uint64_t untold_ = 0;
};

}  // namespace stof::firmware
