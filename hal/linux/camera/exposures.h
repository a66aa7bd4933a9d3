#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <optional>

#include "hal/time.h"

namespace stof::hal::linux {

// When light was collected, as far as the rig can tell. A frame's stamp says when the frame came to
// the kernel, which is later by exposure, readout and bus: cameras look here for the exposure
// behind it. For the thread that drives the trigger. Allocates nothing, does not block.
class Exposures {
 public:
  virtual ~Exposures() = default;
  // The newest exposure that had ended at `stamp`, if it is remembered.
  virtual std::optional<Exposure> ended_at(Time stamp) noexcept = 0;
};

// The last edges, each of which began an exposure of one length. One thread notes them; a thread
// that opens a camera again may look meanwhile.
class EdgeLog {
 public:
  static constexpr std::size_t kDepth = 64;

  // Later than every edge before it.
  void note(Time edge) noexcept {
    const std::size_t count = count_.load(std::memory_order_relaxed);
    edges_[count % kDepth].store(edge.time_since_epoch().count(), std::memory_order_relaxed);
    count_.store(count + 1, std::memory_order_release);
  }
  // The newest edge at or before `time`, if it is remembered.
  std::optional<Time> at_or_before(Time time) const noexcept;
  // The remembered edge that is nearest to `time`; none: nothing is remembered.
  std::optional<Time> nearest(Time time) const noexcept;

 private:
  Time edge(std::size_t number) const noexcept {
    return Time(Duration(edges_[number % kDepth].load(std::memory_order_relaxed)));
  }

  // A reader during note() may see the oldest or the newest edge in that slot; both are valid.
  std::array<std::atomic<Duration::rep>, kDepth> edges_{};
  std::atomic<std::size_t> count_{0};
};

// Sensors that expose at each edge for a fixed time.
class EdgeExposures final : public Exposures {
 public:
  EdgeExposures(const EdgeLog& edges, Duration exposure) noexcept
      : edges_(edges), exposure_(exposure) {}
  std::optional<Exposure> ended_at(Time stamp) noexcept override {
    const std::optional<Time> edge = edges_.at_or_before(stamp - exposure_);
    return edge ? std::optional(Exposure{*edge, *edge + exposure_}) : std::nullopt;
  }

 private:
  const EdgeLog& edges_;
  Duration exposure_;
};

}  // namespace stof::hal::linux
