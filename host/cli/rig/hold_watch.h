#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/cli/live/raw_feed.h"

// When a picture has held still for long enough, and what to do until then.
namespace stof::host {

// What shows the same for as long as it has to.
struct HeldView {
  RawShot first;
  std::vector<dataset::Image<std::uint16_t>> samples;  // of the PMD camera, of each exposure
};

// From one exposure to the next: whether the picture holds still, and for how long it has.
class HoldWatch {
 public:
  // most_motion_px: between successive exposures (picture_motion.h). exposures: that show the same.
  HoldWatch(double most_motion_px, std::size_t exposures)
      : most_motion_px_(most_motion_px), exposures_(exposures) {}

  // A view, where it was held long enough; none: hint() says what to do. After a view the picture
  // has to move on before there is another one.
  std::optional<HeldView> add(RawShot shot);

  const std::string& hint() const { return hint_; }
  // Which of the hints it is.
  int state() const { return static_cast<int>(state_); }

 private:
  enum class State : std::uint8_t { kMoving, kStill, kTaken };

  void tell(State state, std::string hint);
  bool moved_on(const dataset::Image<std::uint8_t>& now) const;

  double most_motion_px_;
  std::size_t exposures_;
  std::optional<HeldView> held_;
  dataset::Image<std::uint8_t> before_;
  std::optional<dataset::Image<std::uint8_t>> taken_;
  State state_ = State::kMoving;
  std::string hint_;
};

}  // namespace stof::host
