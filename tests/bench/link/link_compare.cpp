#include <array>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <map>

#include <poll.h>

#include "tests/bench/link/link_bench.h"

namespace stof::bench {
namespace {

using client::Frame;
using client::Time;

struct Pixels {
  int width = 0;
  int height = 0;
  bool complete = false;
  std::vector<std::uint32_t> depth_width;  // both, as one number
  std::vector<std::uint16_t> source;       // with cause
  std::vector<std::uint8_t> received;
};

// Of a stream of which nothing arrived there may be no image: none, as where a pixel is missing.
template <typename T>
unsigned at(const dsp::ImageView<const T>& image, int x, int y) {
  return y < image.height() ? static_cast<unsigned>(image.row(y)[static_cast<std::size_t>(x)]) : 0U;
}

Pixels copy(const Frame& frame) {
  Pixels pixels{.width = frame.received.width(),
                .height = frame.received.height(),
                .complete = frame.complete(),
                .depth_width = {},
                .source = {},
                .received = {}};
  for (int y = 0; y < pixels.height; ++y) {
    for (int x = 0; x < pixels.width; ++x) {
      pixels.depth_width.push_back(at(frame.depth, x, y) << 16U | at(frame.interval_width, x, y));
      pixels.source.push_back(
          static_cast<std::uint16_t>(at(frame.source, x, y) << 8U | at(frame.cause, x, y)));
      pixels.received.push_back(static_cast<std::uint8_t>(at(frame.received, x, y)));
    }
  }
  return pixels;
}

struct Sum {
  std::uint64_t frames = 0;  // that the straight way brought whole
  std::uint64_t whole = 0;   // of these by way of the impaired one
  std::uint64_t delivered = 0;
  std::uint64_t rows = 0;
  std::uint64_t rows_whole = 0;
  std::uint64_t rows_wrong = 0;
};

// What arrived must be the same, what did not must be none.
bool right(const Pixels& got, const Pixels& sent, std::size_t at) {
  const std::uint8_t marks = got.received[at];
  const std::uint32_t mask = ((marks & client::kHasDepth) != 0 ? 0xFFFF0000U : 0U) |
                             ((marks & client::kHasWidth) != 0 ? 0xFFFFU : 0U);
  const bool source = (marks & client::kHasSource) != 0;
  return got.depth_width[at] == (sent.depth_width[at] & mask) &&
         got.source[at] == (source ? sent.source[at] : 0);
}

void judge(const Pixels& sent, const Pixels* got, Sum& sum) {
  ++sum.frames;
  sum.rows += static_cast<std::uint64_t>(sent.height);
  if (got == nullptr || got->width != sent.width || got->height != sent.height) {
    sum.rows_wrong +=
        got != nullptr && got->width > 0 ? static_cast<std::uint64_t>(sent.height) : 0;
    return;
  }
  ++sum.delivered;
  sum.whole += got->complete ? 1 : 0;
  const auto width = static_cast<std::size_t>(sent.width);
  for (std::size_t begin = 0; begin < sent.received.size(); begin += width) {
    bool whole = true;
    bool wrong = false;
    for (std::size_t at = begin; at < begin + width; ++at) {
      whole = whole && (got->received[at] & client::kHasDepth) != 0;
      wrong = wrong || !right(*got, sent, at);
    }
    sum.rows_whole += whole ? 1 : 0;
    sum.rows_wrong += wrong ? 1 : 0;
  }
}

// Frames of both ways until they are judged, `kLag` frames behind the newest.
class Comparison {
 public:
  explicit Comparison(std::uint32_t frames) : frames_(frames) {}

  void straight(const Frame& frame) {
    if (!begun_ && heard_) {
      begun_ = true;
      first_ = frame.stamp.number + kMargin;
    }
    keep(straight_, frame);
    newest_ = frame.stamp.number;
    while (begun_ && !straight_.empty() && newest_ - straight_.begin()->first >= kLag) {
      settle();
    }
  }
  void impaired(const Frame& frame) {
    heard_ = true;
    keep(impaired_, frame);
  }
  bool done() const { return begun_ && newest_ >= first_ + frames_ + kLag; }
  const Sum& sum() const { return sum_; }
  std::uint64_t unjudged() const { return unjudged_; }

 private:
  using Kept = std::map<std::uint32_t, Pixels>;
  static constexpr std::uint32_t kMargin = 5;
  static constexpr std::uint32_t kLag = 8;

  void keep(Kept& kept, const Frame& frame) const {
    const std::uint32_t number = frame.stamp.number;
    if (begun_ && number >= first_ && number < first_ + frames_) {
      kept.emplace(number, copy(frame));
    }
  }
  void settle() {
    const auto sent = straight_.begin();
    const auto got = impaired_.find(sent->first);
    if (sent->second.complete) {
      judge(sent->second, got == impaired_.end() ? nullptr : &got->second, sum_);
    } else {
      ++unjudged_;
    }
    impaired_.erase(impaired_.begin(), impaired_.upper_bound(sent->first));
    straight_.erase(sent);
  }

  std::uint32_t frames_;
  bool heard_ = false;
  bool begun_ = false;
  std::uint32_t first_ = 0;
  std::uint32_t newest_ = 0;
  Kept straight_;
  Kept impaired_;
  Sum sum_;
  std::uint64_t unjudged_ = 0;
};

}  // namespace

int compare(const Words& words) {
  client::Receiver sensor = subscribe(words[0]);
  client::Receiver impaired = subscribe(words[1]);
  const auto frames = static_cast<std::uint32_t>(std::strtoul(words[2].c_str(), nullptr, 10));
  Comparison comparison(frames);
  constexpr std::chrono::seconds kSilence{10};
  Time heard = Time::clock::now();
  while (!comparison.done() && Time::clock::now() - heard < kSilence) {
    constexpr int kLookMs = 10;
    std::array<pollfd, 2> sockets{{{.fd = sensor.fd(), .events = POLLIN, .revents = 0},
                                   {.fd = impaired.fd(), .events = POLLIN, .revents = 0}}};
    poll(sockets.data(), sockets.size(), kLookMs);
    if (const Result<Frame> frame = sensor.next({})) {
      heard = Time::clock::now();
      comparison.straight(*frame);
    }
    if (const Result<Frame> frame = impaired.next({})) {
      comparison.impaired(*frame);
    }
  }
  const Sum& sum = comparison.sum();
  std::printf(
      "{\"frames\":%llu,\"whole\":%llu,\"delivered\":%llu,\"rows\":%llu,"
      "\"rows_whole\":%llu,\"rows_wrong\":%llu,\"unjudged\":%llu,\"straight\":%s,"
      "\"impaired\":%s}\n",
      static_cast<unsigned long long>(sum.frames), static_cast<unsigned long long>(sum.whole),
      static_cast<unsigned long long>(sum.delivered), static_cast<unsigned long long>(sum.rows),
      static_cast<unsigned long long>(sum.rows_whole),
      static_cast<unsigned long long>(sum.rows_wrong),
      static_cast<unsigned long long>(comparison.unjudged()), json(sensor.statistics()).c_str(),
      json(impaired.statistics()).c_str());
  return 0;
}

}  // namespace stof::bench
