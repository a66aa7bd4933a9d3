#pragma once

#include <cstdint>
#include <optional>

#include "hal/linux/camera/exposures.h"

namespace stof::hal::linux {

// Where one picture of a camera belongs.
struct MatchedExposure {
  Exposure exposure;  // both ends are the stamp where it is not matched
  bool sure = false;
};

// Finds the exposure behind each picture of one camera by its stamp, and does not believe it
// blindly: a picture that was held up until the next exposure looks like one of that. The count
// reveals it. As long as the camera's numbers advance as exposures do, all is well; after a
// step that differs (an exposure without a picture, two pictures for one exposure) nothing is
// matched until a picture again follows the one before it, exposure by exposure, and comes as soon
// after it as those that were believed. So the first picture is never believed, a lost or late one
// costs one or two more, and an old one is not taken for new.
// Not detected: a camera that is always late by whole periods, from its first picture on or from
// one moment on.
class ExposureMatcher {
 public:
  // So many doubtful pictures in a row, and the camera should be opened anew: it may lag for good.
  static constexpr int kHopeless = 16;

  // most_delay: from an exposure's end to its picture's stamp. `exposures` outlives this.
  ExposureMatcher(Exposures& exposures, Duration most_delay) noexcept
      : exposures_(exposures), most_delay_(most_delay) {}

  // To be called for each picture in the camera's order, also for damaged ones. `number` advances
  // by one with each picture that the camera, or its driver, knows of.
  MatchedExposure match(Time stamp, std::uint32_t number) noexcept;
  bool hopeless() const noexcept { return doubtful_ >= kHopeless; }
  // The camera was opened anew.
  void forget() noexcept;

 private:
  struct Claim {
    Exposure exposure;
    std::uint32_t number = 0;
  };

  std::optional<std::uint32_t> steps_since_last(const Exposure& exposure) noexcept;

  Exposures& exposures_;
  Duration most_delay_;
  std::optional<Claim> last_;  // believed or not
  Duration usual_delay_{};
  bool believed_ = false;  // any picture since forget()
  int doubtful_ = 0;       // in a row
};

}  // namespace stof::hal::linux
