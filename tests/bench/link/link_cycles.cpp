#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <mutex>
#include <thread>

#include "tests/bench/link/link_bench.h"

namespace stof::bench {
namespace {

using client::Frame;
using client::Time;

struct Outcome {
  std::vector<double> first_ms;  // to the first whole frame
  std::uint64_t timeouts = 0;    // none within kPatience
  std::uint64_t stale = 0;       // not newer than what anybody had before the cycle
  std::uint64_t old = 0;         // exposed before the subscription by more than kOld
  std::uint64_t torn = 0;        // incomplete
  std::uint64_t inherited = 0;   // of these, at a port that another client had just left
  double oldest_ms = 0;          // exposure before the subscription
};

constexpr std::chrono::seconds kPatience{5};
constexpr double kOldMs = 250;  // more than any frame takes from its exposure to its arrival

class Cycles {
 public:
  Cycles(std::string sensor, std::uint64_t count)
      : sensor_(std::move(sensor)), left_(static_cast<std::int64_t>(count)) {}

  void run() {
    Outcome mine;
    while (left_.fetch_sub(1) > 0) {
      cycle(mine);
    }
    const std::scoped_lock lock(mutex_);
    sum_.first_ms.insert(sum_.first_ms.end(), mine.first_ms.begin(), mine.first_ms.end());
    sum_.timeouts += mine.timeouts;
    sum_.stale += mine.stale;
    sum_.old += mine.old;
    sum_.torn += mine.torn;
    sum_.inherited += mine.inherited;
    sum_.oldest_ms = std::max(sum_.oldest_ms, mine.oldest_ms);
  }

  const Outcome& outcome() const { return sum_; }

 private:
  void cycle(Outcome& mine) {
    const std::uint64_t before = newest_.load();
    const Time began = Time::clock::now();
    client::Receiver receiver = subscribe(sensor_);
    while (Time::clock::now() - began < kPatience) {
      const Result<Frame> frame = receiver.next(kPatience);
      if (!frame) {
        break;
      }
      judge(*frame, before, began, mine);
      if (frame->complete()) {
        mine.first_ms.push_back(milliseconds(frame->last_packet - began));
        leave(receiver.port());
        return;
      }
      ++mine.torn;
      mine.inherited += inherited(receiver.port(), began) ? 1U : 0U;
    }
    ++mine.timeouts;
  }

  // Notes that a client is about to leave a port.
  void leave(std::uint16_t port) {
    const std::scoped_lock lock(mutex_);
    left_at_[port] = Time::clock::now();
  }
  // Whether a client left the port so late that the sensor may still have been at its last frame.
  bool inherited(std::uint16_t port, Time began) {
    constexpr std::chrono::milliseconds kFrame{100};
    const std::scoped_lock lock(mutex_);
    const auto found = left_at_.find(port);
    return found != left_at_.end() && began - found->second < kFrame;
  }

  void judge(const Frame& frame, std::uint64_t before, Time began, Outcome& mine) {
    const std::uint64_t now = packed(frame.stamp);
    if (before != kNothing &&
        (!newer(number(now), number(before)) || !newer(freshness(now), freshness(before)))) {
      ++mine.stale;
    }
    const double ms =
        1e-6 * static_cast<double>(nanoseconds(began) - frame.stamp.exposure_middle_ns);
    mine.oldest_ms = std::max(mine.oldest_ms, ms);
    mine.old += ms > kOldMs ? 1U : 0U;
    std::uint64_t known = newest_.load();
    while ((known == kNothing || newer(number(now), number(known))) &&
           !newest_.compare_exchange_weak(known, now)) {
    }
  }

  static constexpr std::uint64_t kNothing = ~std::uint64_t{0};
  static constexpr std::uint64_t packed(const wire::FrameStamp& stamp) {
    return std::uint64_t{stamp.number} << 32U | stamp.freshness;
  }
  static constexpr std::uint32_t number(std::uint64_t packed) {
    return static_cast<std::uint32_t>(packed >> 32U);
  }
  static constexpr std::uint32_t freshness(std::uint64_t packed) {
    return static_cast<std::uint32_t>(packed);
  }

  std::string sensor_;
  std::atomic<std::int64_t> left_;
  std::atomic<std::uint64_t> newest_{kNothing};  // that anybody was given
  std::mutex mutex_;
  std::map<std::uint16_t, Time> left_at_;
  Outcome sum_;
};

}  // namespace

int cycles(const Words& words) {
  Cycles cycles(words[0], std::strtoull(words[1].c_str(), nullptr, 10));
  const Time began = Time::clock::now();
  {
    std::vector<std::jthread> clients;
    for (std::uint64_t i = 0; i < std::strtoull(words[2].c_str(), nullptr, 10); ++i) {
      clients.emplace_back([&cycles] { cycles.run(); });
    }
  }
  const Outcome& outcome = cycles.outcome();
  std::printf(
      "{\"cycles\":%zu,\"seconds\":%.3f,\"timeouts\":%llu,\"stale\":%llu,\"old\":%llu,"
      "\"torn\":%llu,\"inherited\":%llu,\"oldest_ms\":%.3f,%s}\n",
      outcome.first_ms.size(), 1e-3 * milliseconds(Time::clock::now() - began),
      static_cast<unsigned long long>(outcome.timeouts),
      static_cast<unsigned long long>(outcome.stale), static_cast<unsigned long long>(outcome.old),
      static_cast<unsigned long long>(outcome.torn),
      static_cast<unsigned long long>(outcome.inherited), outcome.oldest_ms,
      quantiles("first", outcome.first_ms).c_str());
  return 0;
}

}  // namespace stof::bench
