#include "hal/linux/v4l2/v4l2_pmd.h"

#include <algorithm>
#include <span>
#include <utility>

#include "dsp/base/check.h"

namespace stof::hal::linux {
namespace {

constexpr int kSamples = 4;

V4l2Options device_options(const V4l2PmdOptions& options) {
  STOF_CHECK(options.exposures != nullptr && options.integration >= Duration::zero());
  return {.node = options.node,
          .width = options.width,
          .height = kSamples * options.height,
          .formats = options.formats,
          .exposure = {},
          .gain = {},
          .sysfs = options.sysfs};
}

}  // namespace

V4l2Pmd::V4l2Pmd(V4l2Calls& calls, hal::Clock& clock, V4l2PmdOptions options)
    : calls_(calls),
      clock_(clock),
      options_(std::move(options)),
      feed_(calls, clock, device_options(options_), *options_.exposures, options_.most_delay) {
  samples_.resize(static_cast<std::size_t>(options_.width) *
                  static_cast<std::size_t>(options_.height) * kSamples * kSlots);
}

V4l2Pmd::~V4l2Pmd() {
  STOF_CHECK(out_ == 0);
  feed_.drop_all();
}

std::expected<std::unique_ptr<V4l2Pmd>, OpenError> V4l2Pmd::open(V4l2Calls& calls,
                                                                 hal::Clock& clock,
                                                                 V4l2PmdOptions options) {
  std::unique_ptr<V4l2Pmd> camera(new V4l2Pmd(calls, clock, std::move(options)));
  if (auto opened = camera->feed_.device().open(); !opened) {
    return std::unexpected(std::move(opened.error()));
  }
  return camera;
}

Status V4l2Pmd::reopen() noexcept {
  feed_.forget();
  corrupt_ = false;
  return feed_.device().open() ? Status::kOk : Status::kDeviceLost;
}

Result<BorrowedFrame<PmdFrame>> V4l2Pmd::wait_frame(Time deadline) noexcept {
  for (;;) {
    const Status status = feed_.drain(kSlots - out_);
    if (status == Status::kDeviceLost) {
      return fail(status);
    }
    corrupt_ = corrupt_ || status == Status::kCorrupt;
    if (feed_.oldest() != nullptr) {
      return hand_out();
    }
    if (std::exchange(corrupt_, false)) {
      return fail(Status::kCorrupt);
    }
    const Time now = clock_.now();
    if (now >= deadline) {
      return fail(Status::kTimeout);
    }
    V4l2Feed* const feed = &feed_;
    wait_for_any(calls_, std::span(&feed, 1), deadline - now);
  }
}

BorrowedFrame<PmdFrame> V4l2Pmd::hand_out() noexcept {
  const auto free = std::ranges::find(taken_, false);
  STOF_CHECK(free != taken_.end());  // drain() keeps no more than there are slots
  *free = true;
  ++out_;
  const int slot = static_cast<int>(free - taken_.begin());
  const V4l2Arrival arrival = feed_.take();
  const V4l2Format& format = feed_.device().format();
  const std::size_t row = row_bytes(format.pixels, options_.width);
  PmdFrame frame;
  frame.sequence = arrival.buffer.sequence;
  frame.exposures = quarters(arrival);
  const std::ptrdiff_t plane = std::ptrdiff_t{options_.width} * options_.height;
  for (int k = 0; k < kSamples; ++k) {
    const dsp::ImageView<std::uint16_t> sample(samples_.data() + plane * (kSamples * slot + k),
                                               options_.width, options_.height);
    for (int y = 0; y < options_.height; ++y) {
      const auto line = static_cast<std::size_t>(k * options_.height + y);
      to_samples(format.pixels, {arrival.buffer.data + line * format.stride, row}, sample.row(y));
    }
    frame.samples[static_cast<std::size_t>(k)] = sample;
  }
  feed_.device().release(arrival.buffer);
  return {frame, *this, slot};
}

std::array<Exposure, 4> V4l2Pmd::quarters(const V4l2Arrival& arrival) const noexcept {
  const Time begin = arrival.exposure.begin;
  Duration whole = arrival.exposure.end - begin;
  if (arrival.matched && options_.integration > Duration::zero()) {
    whole = options_.integration;
  }
  std::array<Exposure, 4> parts;
  for (int k = 0; k < kSamples; ++k) {
    parts[static_cast<std::size_t>(k)] = {begin + whole * k / kSamples,
                                          begin + whole * (k + 1) / kSamples};
  }
  return parts;
}

void V4l2Pmd::give_back(int slot) noexcept {
  const auto index = static_cast<std::size_t>(slot);
  STOF_CHECK(taken_[index]);
  taken_[index] = false;
  --out_;
}

}  // namespace stof::hal::linux
