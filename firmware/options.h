#pragma once

#include <cstdint>
#include <expected>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "dsp/depth/depth_maker.h"

// stofd's command line. Used once, before the loop.
namespace stof::firmware {

struct Options {
  bool help = false;
  std::uint64_t frames = 0;  // stop after so many; 0: never
  std::optional<int> period_ms;
  std::string calibration;  // file; empty: the board's own
  std::uint32_t device_id = 1;
  std::optional<std::uint32_t> session_id;
  std::optional<int> disparities;  // else what the rig asks for
  // depth.match.disparities is filled in from the above.
  dsp::DepthParams depth{.match = dsp::for_depth(*dsp::find_preset("fast")), .fusion = {}};
  std::vector<std::string_view> board;  // everything that is not ours, in order
};

// Error: one line, what, where and what to do. Views refer to `arguments`.
std::expected<Options, std::string> parse_options(std::span<const std::string_view> arguments);

// One flag per line.
std::string options_usage();

}  // namespace stof::firmware
