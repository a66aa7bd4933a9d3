#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <ctime>

#include "tests/bench/link/link_bench.h"

namespace stof::bench {
namespace {

using client::Frame;
using client::Time;

volatile std::sig_atomic_t g_stop = 0;  // NOLINT: what a signal handler may write

double cpu_seconds() {
  timespec used{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &used);
  return static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);
}

class Meter {
 public:
  explicit Meter(Time began) : began_(began) {}

  void count(const Frame& frame) {
    if (!order_.advances(frame)) {
      ++disordered_;
    }
    if (order_.new_session()) {
      tell_first(frame);
    }
    const double cpu = cpu_seconds();
    if (frames_ == 0) {
      first_ = frame.last_packet;
      cpu_ = cpu;
    } else {
      used_.push_back(1e3 * (cpu - used_before_));
    }
    used_before_ = cpu;
    ++frames_;
    last_ = frame.last_packet;
    latencies_.push_back(1e-6 * static_cast<double>(nanoseconds(frame.last_packet) -
                                                    frame.stamp.exposure_middle_ns));
    if (frame.info) {
      ++infos_;
      for (std::size_t i = 0; i < stages_us_.size(); ++i) {
        stages_us_[i] += frame.info->stage_us[i];
      }
      sending_.push_back(1e-3 * frame.info->stage_us.back());
      ready_us_ += frame.info->latency_ns / 1000;
      packets_ += frame.packets;
    }
  }

  void tell(const wire::HealthReport& health) {
    if (health.uptime_ms == uptime_) {
      return;
    }
    uptime_ = health.uptime_ms;
    std::printf("{\"health\":%s,\"frames\":%llu,\"late\":%llu,\"dropped\":%llu}\n",
                json(health.control).c_str(),
                static_cast<unsigned long long>(health.counters.frames_published),
                static_cast<unsigned long long>(health.counters.deadline_misses),
                static_cast<unsigned long long>(health.counters.link_drops));
    std::fflush(stdout);
  }

  void summary(const client::Statistics& statistics) const {
    std::printf("{\"seconds\":%.3f,\"cpu\":%.4f,\"frames\":%llu,\"infos\":%llu,\"ready_us\":%lld,",
                1e-3 * milliseconds(last_ - first_), cpu_seconds() - cpu_,
                static_cast<unsigned long long>(frames_), static_cast<unsigned long long>(infos_),
                static_cast<long long>(ready_us_));
    std::printf("\"stages_us\":[");
    for (std::size_t i = 0; i < stages_us_.size(); ++i) {
      std::printf("%s%llu", i == 0 ? "" : ",", static_cast<unsigned long long>(stages_us_[i]));
    }
    std::printf("],\"packets\":%llu,\"disordered\":%llu,%s,%s,%s,\"statistics\":%s}\n",
                static_cast<unsigned long long>(packets_),
                static_cast<unsigned long long>(disordered_),
                quantiles("latency", latencies_).c_str(), quantiles("sending", sending_).c_str(),
                quantiles("used", used_).c_str(), json(statistics).c_str());
  }

 private:
  void tell_first(const Frame& frame) const {
    std::printf(
        "{\"session\":%u,\"number\":%u,\"freshness\":%u,\"complete\":%s,\"ms\":%.3f,"
        "\"began_ns\":%lld,\"arrived_ns\":%lld,\"exposed_ns\":%lld}\n",
        frame.origin.session_id, frame.stamp.number, frame.stamp.freshness,
        frame.complete() ? "true" : "false", milliseconds(frame.last_packet - began_),
        static_cast<long long>(nanoseconds(began_)),
        static_cast<long long>(nanoseconds(frame.last_packet)),
        static_cast<long long>(frame.stamp.exposure_middle_ns));
    std::fflush(stdout);
  }

  Time began_;
  Time first_;
  Time last_;
  double cpu_ = 0;
  Order order_;
  std::uint64_t frames_ = 0;
  std::uint64_t infos_ = 0;
  std::array<std::uint64_t, 6> stages_us_{};  // as FrameInfo::stage_us
  std::int64_t ready_us_ = 0;  // from the exposure to the sending of the first packet
  std::uint64_t packets_ = 0;
  std::uint64_t disordered_ = 0;
  std::uint64_t uptime_ = 0;
  std::vector<double> latencies_;
  std::vector<double> sending_;  // ms, of each frame that told: without the waits of pacing
  std::vector<double> used_;     // ms of processor, from frame to frame
  double used_before_ = 0;
};

}  // namespace

int receive(const Words& words) {
  struct sigaction action{};
  action.sa_handler = [](int /*signal*/) { g_stop = 1; };
  sigaction(SIGTERM, &action, nullptr);
  const std::chrono::duration<double> duration(std::strtod(words[1].c_str(), nullptr));
  const Time began = Time::clock::now();
  client::Receiver receiver = subscribe(words[0], words.size() > 2 ? words[2] : std::string());
  Meter meter(began);
  constexpr std::chrono::milliseconds kLook{100};
  while (g_stop == 0 && (duration.count() == 0 || Time::clock::now() - began < duration)) {
    const Result<Frame> frame = receiver.next(kLook);
    if (frame) {
      meter.count(*frame);
    } else if (frame.error() == Status::kDeviceLost) {
      return 1;
    }
    if (receiver.health()) {
      meter.tell(*receiver.health());
    }
  }
  meter.summary(receiver.statistics());
  return 0;
}

}  // namespace stof::bench
