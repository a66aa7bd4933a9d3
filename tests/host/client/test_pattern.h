#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "firmware/wire/frame/cloud.h"
#include "host/client/frame/frame.h"
#include "host/client/reassembler.h"
#include "tests/host/client/sent_frame.h"

// Frames whose every pixel tells its frame and its place, in all eight streams: whatever arrives
// can be judged alone. Smooth enough for RVL.
namespace stof::test {

struct PatternSizes {
  int width = 64;
  int height = 48;
  int pmd_width = 16;
  int pmd_height = 12;
  int cloud_step = 8;
};

// 97 and 5 are odd: two frames differ everywhere unless their numbers differ by a multiple of
// 16,384 (256 where pixels have 8 bits).
constexpr std::uint16_t pattern16(std::uint32_t number, std::size_t place, unsigned salt) noexcept {
  return static_cast<std::uint16_t>(1000 * salt + (97 * number) % 16'384 + place % 64);
}
constexpr std::uint8_t pattern8(std::uint32_t number, std::size_t place, unsigned salt) noexcept {
  return static_cast<std::uint8_t>(5 * number + place / 7 + salt);
}
constexpr dsp::Disparity pattern_disparity(std::uint32_t number, std::size_t place) noexcept {
  return place % 11 == 0 ? dsp::Disparity::none()
                         : dsp::Disparity::from_raw(
                               static_cast<std::int16_t>(pattern16(number, place, 9) - 20'000));
}

inline wire::StreamChoice every_stream(wire::Coding coding, bool parity, int cloud_step) {
  wire::StreamChoice choice;
  choice.coding.fill(coding);
  choice.parity = parity;
  choice.cloud_step = cloud_step;
  return choice;
}

// What kQuantised makes of pixels as above: their widths are 1,000 and more, which gives steps
// of 32.
constexpr dsp::QuarterMm quantised_depth_of(dsp::QuarterMm depth) noexcept {
  return static_cast<dsp::QuarterMm>((depth + 16) / 32 * 32);
}
constexpr dsp::QuarterMm quantised_width_of(dsp::QuarterMm depth, dsp::QuarterMm width) noexcept {
  const int moved = std::abs(quantised_depth_of(depth) - depth);
  return static_cast<dsp::QuarterMm>((width + 2 * moved + 31) / 32 * 32);
}

// The pixels of one frame as they are sent.
class PatternFrame {
 public:
  PatternFrame(std::uint32_t number, const PatternSizes& sizes)
      : sizes_(sizes),
        depth_(pixels(sizes.width, sizes.height)),
        width_(depth_.size()),
        source_(depth_.size()),
        cause_(depth_.size()),
        disparity_(depth_.size()),
        left_(depth_.size()),
        right_(depth_.size()),
        pmd_(4 * pixels(sizes.pmd_width, sizes.pmd_height)) {
    for (std::size_t i = 0; i < depth_.size(); ++i) {
      depth_[i] = pattern16(number, i, 4);
      width_[i] = pattern16(number, i, 1);
      source_[i] = static_cast<dsp::Source>(pattern8(number, i, 0) % 16);
      cause_[i] = static_cast<dsp::Cause>(pattern8(number, i, 0) / 16);
      disparity_[i] = pattern_disparity(number, i);
      left_[i] = pattern8(number, i, 50);
      right_[i] = pattern8(number, i, 100);
    }
    for (std::size_t i = 0; i < pmd_.size(); ++i) {
      pmd_[i] = pattern16(number, i, 20);
    }
  }

  wire::FrameImages images() {
    const int w = sizes_.width;
    const int h = sizes_.height;
    wire::FrameImages images{.map = {.depth = {depth_.data(), w, h},
                                     .width = {width_.data(), w, h},
                                     .source = {source_.data(), w, h},
                                     .cause = {cause_.data(), w, h}},
                             .disparity = {disparity_.data(), w, h},
                             .pmd = {},
                             .left = {left_.data(), w, h},
                             .right = {right_.data(), w, h}};
    const std::size_t sample = pixels(sizes_.pmd_width, sizes_.pmd_height);
    for (std::size_t k = 0; k < 4; ++k) {
      images.pmd[k] = {pmd_.data() + k * sample, sizes_.pmd_width, sizes_.pmd_height};
    }
    return images;
  }

  // All streams in the order of their numbers, each as docs/WIRE.md says that it travels when raw;
  // or depth and width as they are after kQuantised.
  std::vector<std::byte> bytes(bool quantised = false) const {
    std::vector<std::byte> out;
    const auto add8 = [&out](unsigned value) { out.push_back(static_cast<std::byte>(value)); };
    const auto add16 = [&add8](unsigned value) {
      add8(value % 256);
      add8(value / 256 % 256);
    };
    for (const dsp::QuarterMm depth : depth_) {
      add16(quantised ? quantised_depth_of(depth) : depth);
    }
    for (std::size_t i = 0; i < width_.size(); ++i) {
      add16(quantised ? quantised_width_of(depth_[i], width_[i]) : width_[i]);
    }
    for (std::size_t i = 0; i < source_.size(); ++i) {
      add8(static_cast<unsigned>(source_[i]) + 16 * static_cast<unsigned>(cause_[i]));
    }
    for (const dsp::Disparity disparity : disparity_) {
      add16(static_cast<unsigned>(32'768 + disparity.raw));
    }
    std::ranges::for_each(pmd_, add16);
    std::ranges::for_each(left_, add8);
    std::ranges::for_each(right_, add8);
    const int step = sizes_.cloud_step;
    for (int y = 0; y * step < sizes_.height; ++y) {
      for (int x = 0; x * step < sizes_.width; ++x) {
        const client::CloudPoint one = point(x, y);
        add16(static_cast<std::uint16_t>(one.x_mm));
        add16(static_cast<std::uint16_t>(one.y_mm));
        add16(one.depth);
        add16(one.interval_width);
      }
    }
    return out;
  }

  // The point of a block, by the words of docs/WIRE.md. The lens is that of Coder.
  client::CloudPoint point(int bx, int by) const {
    client::CloudPoint point;
    int nearest = 0;
    for (int y = by * sizes_.cloud_step; y < std::min((by + 1) * sizes_.cloud_step, sizes_.height);
         ++y) {
      for (int x = bx * sizes_.cloud_step; x < std::min((bx + 1) * sizes_.cloud_step, sizes_.width);
           ++x) {
        const auto at = static_cast<std::size_t>(y * sizes_.width + x);
        const int near_bound = 2 * depth_[at] - width_[at];
        if (point.depth == 0 || near_bound < nearest) {
          nearest = near_bound;
          point = {.x_mm = wire::point_mm(x, depth_[at], 65536, 0),
                   .y_mm = wire::point_mm(y, depth_[at], 65536, 0),
                   .depth = depth_[at],
                   .interval_width = width_[at]};
        }
      }
    }
    return point;
  }

 private:
  static std::size_t pixels(int width, int height) {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }

  PatternSizes sizes_;
  std::vector<dsp::QuarterMm> depth_;
  std::vector<dsp::QuarterMm> width_;
  std::vector<dsp::Source> source_;
  std::vector<dsp::Cause> cause_;
  std::vector<dsp::Disparity> disparity_;
  std::vector<std::uint8_t> left_;
  std::vector<std::uint8_t> right_;
  std::vector<std::uint16_t> pmd_;
};

// told: what the pixels tell; without it the frame's number.
inline std::vector<Datagram> pattern_datagrams(const FrameSpec& spec, const PatternSizes& sizes,
                                               const wire::StreamChoice& choice,
                                               std::optional<std::uint32_t> told = {}) {
  PatternFrame frame(told.value_or(spec.number), sizes);
  Coder coder(spec.origin, {.width = sizes.width,
                            .height = sizes.height,
                            .pmd_width = sizes.pmd_width,
                            .pmd_height = sizes.pmd_height});
  return coder.code(stamp_of(spec), frame.images(), choice, {.steady_frames = spec.steady_frames});
}

// What of a received frame is as it should be.
struct Judgement {
  std::uint64_t arrived = 0;  // pixels that are those of this frame and place
  std::uint64_t missing = 0;  // that are none and not marked
  std::uint64_t wrong = 0;    // anything else

  friend Judgement operator+(const Judgement& a, const Judgement& b) {
    return {a.arrived + b.arrived, a.missing + b.missing, a.wrong + b.wrong};
  }
};

// told(place) is what was sent. An empty image has nothing to judge.
template <typename T, typename Told>
Judgement judge(const client::Frame& frame, wire::Stream stream, dsp::ImageView<const T> image,
                const T& none, Told told, int first_row = 0) {
  Judgement result;
  const dsp::ImageView<const std::uint8_t> marks = frame.marks[client::index_of(stream)];
  std::size_t place = static_cast<std::size_t>(first_row) * static_cast<std::size_t>(image.width());
  for (int y = 0; y < image.height(); ++y) {
    const std::span<const T> row = image.row(y);
    const std::span<const std::uint8_t> marked = marks.row(first_row + y);
    for (std::size_t x = 0; x < row.size(); ++x, ++place) {
      const bool here = (marked[x] & client::mark_of(stream)) != 0;
      const bool right = row[x] == (here ? told(place) : none);
      result.arrived += here && right ? 1U : 0U;
      result.missing += !here && right ? 1U : 0U;
      result.wrong += right ? 0U : 1U;
    }
  }
  return result;
}

// Of every stream but the cloud; n: what the pixels tell.
inline Judgement judge(const client::Frame& frame, std::uint32_t n) {
  using wire::Stream;
  Judgement all =
      judge(frame, Stream::kDepth, frame.depth, dsp::kNoDepth,
            [n](std::size_t i) { return pattern16(n, i, 4); }) +
      judge(frame, Stream::kWidth, frame.interval_width, dsp::QuarterMm{0},
            [n](std::size_t i) { return pattern16(n, i, 1); }) +
      judge(frame, Stream::kSource, frame.source, dsp::Source::kNone,
            [n](std::size_t i) { return static_cast<dsp::Source>(pattern8(n, i, 0) % 16); }) +
      judge(frame, Stream::kSource, frame.cause, dsp::Cause::kNone,
            [n](std::size_t i) { return static_cast<dsp::Cause>(pattern8(n, i, 0) / 16); }) +
      judge(frame, Stream::kDisparity, frame.disparity, dsp::Disparity::none(),
            [n](std::size_t i) { return pattern_disparity(n, i); }) +
      judge(frame, Stream::kGreyLeft, frame.left, std::uint8_t{0},
            [n](std::size_t i) { return pattern8(n, i, 50); }) +
      judge(frame, Stream::kGreyRight, frame.right, std::uint8_t{0},
            [n](std::size_t i) { return pattern8(n, i, 100); });
  for (std::size_t k = 0; k < frame.pmd.size(); ++k) {
    const dsp::ImageView<const std::uint16_t> sample = frame.pmd[k];
    all = all + judge(
                    frame, Stream::kPmdRaw, sample, std::uint16_t{0},
                    [n](std::size_t i) { return pattern16(n, i, 20); },
                    static_cast<int>(k) * sample.height());
  }
  return all;
}
inline Judgement judge(const client::Frame& frame) { return judge(frame, frame.stamp.number); }

// The newest frame that the packets make.
inline std::optional<client::Frame> push_all(client::Reassembler& reassembler,
                                             const std::vector<Datagram>& packets) {
  std::optional<client::Frame> frame;
  for (const Datagram& packet : packets) {
    reassembler.push(packet, client::Time{});
    if (const std::optional<client::Frame> next = reassembler.take()) {
      frame = next;
    }
  }
  return frame;
}

}  // namespace stof::test
