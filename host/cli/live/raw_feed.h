#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "dataset/image.h"
#include "dsp/calib/pinhole.h"
#include "host/cli/receive.h"

// Raw pictures of a live sensor for commands that take longer over one than it takes to come.
namespace stof::host {

struct RawShot {
  std::uint32_t exposure = 0;  // its id: RawExposure::stamp.freshness
  dataset::Image<std::uint8_t> left;
  dataset::Image<std::uint8_t> right;
  dataset::Image<std::uint16_t> pmd;   // A0 to A3 below each other; empty: not asked for
  std::int32_t pmd_after_pair_us = 0;  // from the middle of the pair's exposure to theirs
};

struct RawFeedOptions {
  bool pmd = false;         // the PMD camera's samples too
  std::uint16_t every = 4;  // one exposure of so many frames
};

// Subscribes, and receives in a thread of its own: the newest exposure that has all its pictures is
// kept, those before it are left out.
class RawFeed {
 public:
  // Throws Failure where nothing can be subscribed: no key, no such host.
  RawFeed(const ReceiveOptions& where, const RawFeedOptions& what);
  RawFeed(const RawFeed&) = delete;
  RawFeed& operator=(const RawFeed&) = delete;
  ~RawFeed();

  // The next exposure, one that was not returned before; none after `patience`. Throws Failure
  // (exit code 1) with one line where the sensor was silent for ReceiveOptions::timeout_s, or sends
  // frames and no raw pictures: it refuses them, another one has them, it has none, or no PMD
  // camera where one is asked for.
  std::optional<RawShot> next(std::chrono::milliseconds patience);

  // The left camera as depth is told in, by the sensor's own calibration; of the raw pictures it is
  // roughly true. None: it has not told it yet.
  std::optional<dsp::Pinhole> told_lens() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace stof::host
