#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/client/frame/frame.h"

// Frames as the page gets them. docs: docs/VIEWER.md.
namespace stof::viewer {

// What a page looks at; bits of a set.
enum Plane : std::uint8_t { kDepth = 1, kWidth = 2, kSource = 4, kLeft = 8 };
using Planes = std::uint8_t;
inline constexpr Planes kAllPlanes = kDepth | kWidth | kSource | kLeft;

// "depth", "width", "source", "left".
std::optional<Plane> plane_named(std::string_view name) noexcept;

// A frame that outlives the receiver's views. A plane that was not sent is empty. What did not
// arrive is 0, as in client::Frame.
struct FramePlanes {
  std::string facts{};  // JSON members of the head, without braces
  int width = 0;        // of depth, width and source
  int height = 0;
  int left_width = 0;
  int left_height = 0;
  std::vector<dsp::QuarterMm> depth{};
  std::vector<dsp::QuarterMm> interval_width{};
  std::vector<dsp::Source> source{};
  std::vector<std::uint8_t> left{};
};

// latency_ms: exposure to arrival; none where it is not known.
FramePlanes copy_of(const client::Frame& frame, std::optional<double> latency_ms);

// Appends the message that carries those of the wanted planes that there are: u32 bytes of the
// head, the head in JSON, blanks up to a multiple of 8 bytes, then the planes, row by row; all
// little-endian.
void append_frame_message(const FramePlanes& frame, Planes wanted,
                          std::vector<std::uint8_t>& bytes);

}  // namespace stof::viewer
