#include "host/viewer/frame_message.h"

#include <algorithm>
#include <array>
#include <bit>
#include <span>
#include <utility>

#include <nlohmann/json.hpp>

#include "firmware/wire/frame_info.h"

namespace stof::viewer {
namespace {

static_assert(std::endian::native == std::endian::little, "planes are copied as they are");

constexpr std::array<std::pair<std::string_view, Plane>, 4> kPlaneNames{
    {{"depth", kDepth}, {"width", kWidth}, {"source", kSource}, {"left", kLeft}}};
constexpr std::size_t kAligned = 8;

template <typename T>
std::vector<T> pixels_of(const dsp::ImageView<const T>& image) {
  std::vector<T> pixels;
  if (!image.empty()) {
    pixels.reserve(static_cast<std::size_t>(image.width()) *
                   static_cast<std::size_t>(image.height()));
    for (int y = 0; y < image.height(); ++y) {
      const std::span<const T> row = image.row(y);
      pixels.insert(pixels.end(), row.begin(), row.end());
    }
  }
  return pixels;
}

nlohmann::json calibration_of(const client::Frame& frame) {
  constexpr double kOne = 65536;
  if (!frame.calibration || frame.calibration->image_width != frame.depth.width() ||
      frame.calibration->image_height != frame.depth.height()) {
    return nullptr;
  }
  const wire::CalibrationPacket& of = *frame.calibration;
  return {{"fx", of.fx / kOne},
          {"fy", of.fy / kOne},
          {"cx", of.cx / kOne},
          {"cy", of.cy / kOne},
          {"max_range_m", of.max_range / double{dsp::kQuarterMmPerMetre}}};
}

template <typename T>
void append(const std::vector<T>& pixels, std::vector<std::uint8_t>& bytes) {
  const std::span<const std::byte> raw = std::as_bytes(std::span(pixels));
  const std::size_t at = bytes.size();
  bytes.resize(at + raw.size());
  std::ranges::transform(raw, bytes.begin() + static_cast<std::ptrdiff_t>(at),
                         [](std::byte one) { return std::to_integer<std::uint8_t>(one); });
}

}  // namespace

std::optional<Plane> plane_named(std::string_view name) noexcept {
  for (const auto& [known, plane] : kPlaneNames) {
    if (known == name) {
      return plane;
    }
  }
  return std::nullopt;
}

FramePlanes copy_of(const client::Frame& frame, std::optional<double> latency_ms) {
  nlohmann::json facts = {{"frame", frame.stamp.number}, {"session", frame.origin.session_id},
                          {"packets", frame.packets},    {"missing_packets", frame.missing_packets},
                          {"latency_ms", nullptr},       {"calibration", calibration_of(frame)}};
  if (latency_ms) {
    facts["latency_ms"] = *latency_ms;
  }
  if (frame.info) {
    facts["sensors"] = wire::sensors_of(*frame.info);
    facts["compute_ms"] = static_cast<double>(frame.info->compute_ns) / 1e6;
  }
  const std::string text = facts.dump();
  return {.facts = text.substr(1, text.size() - 2),
          .width = frame.depth.width(),
          .height = frame.depth.height(),
          .left_width = frame.left.width(),
          .left_height = frame.left.height(),
          .depth = pixels_of(frame.depth),
          .interval_width = pixels_of(frame.interval_width),
          .source = pixels_of(frame.source),
          .left = pixels_of(frame.left)};
}

void append_frame_message(const FramePlanes& frame, Planes wanted,
                          std::vector<std::uint8_t>& bytes) {
  const auto sent = [&](Plane plane, bool there) { return (wanted & plane) != 0 && there; };
  const bool depth = sent(kDepth, !frame.depth.empty());
  const bool width = sent(kWidth, !frame.interval_width.empty());
  const bool source = sent(kSource, !frame.source.empty());
  const bool left = sent(kLeft, !frame.left.empty());
  nlohmann::json planes = nlohmann::json::array();
  for (const auto& [name, plane] : kPlaneNames) {
    if ((plane == kDepth && depth) || (plane == kWidth && width) || (plane == kSource && source) ||
        (plane == kLeft && left)) {
      planes.push_back(name);
    }
  }
  std::string head = "{" + frame.facts + ",\"size\":[" + std::to_string(frame.width) + "," +
                     std::to_string(frame.height) + "],\"left_size\":[" +
                     std::to_string(frame.left_width) + "," + std::to_string(frame.left_height) +
                     "],\"planes\":" + planes.dump() + "}";
  head.append((kAligned - (4 + head.size()) % kAligned) % kAligned, ' ');
  const auto size = static_cast<std::uint32_t>(head.size());
  for (unsigned shift = 0; shift < 32; shift += 8) {
    bytes.push_back(static_cast<std::uint8_t>(size >> shift));
  }
  bytes.insert(bytes.end(), head.begin(), head.end());
  if (depth) {
    append(frame.depth, bytes);
  }
  if (width) {
    append(frame.interval_width, bytes);
  }
  if (source) {
    append(frame.source, bytes);
  }
  if (left) {
    append(frame.left, bytes);
  }
}

}  // namespace stof::viewer
