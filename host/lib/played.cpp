#include "host/lib/played.h"

#include <algorithm>
#include <chrono>
#include <thread>

namespace stof::lib {
namespace {

// A pause of the recording is not waited for longer than this.
constexpr std::chrono::nanoseconds kMostPause = std::chrono::seconds(1);

}  // namespace

void Played::plan(std::uint64_t log_time) {
  const client::Time now = client::Time::clock::now();
  if (pace_percent_ == 0 || at_ns_ == 0 || log_time <= at_ns_) {
    due_ = now;
    return;
  }
  constexpr std::uint64_t kPercent = 100;
  const std::uint64_t most = static_cast<std::uint64_t>(kMostPause.count()) * pace_percent_;
  const std::uint64_t step = log_time - at_ns_;  // at full pace
  const std::chrono::nanoseconds pause =
      step >= most / kPercent ? kMostPause
                              : std::chrono::nanoseconds(step * kPercent / pace_percent_);
  // A program that was slow gets on at the pace again, and not faster.
  due_ = std::max(due_, now - kMostPause) + pause;
}

stof_status Played::next(client::Duration timeout, client::Frame& frame) {
  const client::Time begin = client::Time::clock::now();
  if (!ahead_) {
    ahead_ = playback_.next();
    if (!ahead_) {
      return STOF_END;
    }
    plan(ahead_->log_time);
  }
  if (pace_percent_ != 0 && due_ > begin) {
    if (due_ - begin > timeout) {
      std::this_thread::sleep_for(timeout);
      return STOF_TIMEOUT;
    }
    std::this_thread::sleep_until(due_);
  }
  shown_ = std::exchange(ahead_, std::nullopt);
  at_ns_ = shown_->log_time;
  has_calibration_ = shown_->calibration.has_value();
  frame = shown_->whole_view();
  frame.first_packet = client::Time::clock::now();
  frame.last_packet = frame.first_packet;
  return STOF_OK;
}

bool Played::keep(recording::RecordedFrame& to) {
  if (!shown_) {
    return false;
  }
  to = *std::exchange(shown_, std::nullopt);
  return true;
}

client::Time Played::due() const {
  return ahead_ && pace_percent_ != 0 ? due_ : client::Time::clock::now();
}

client::LinkState Played::link() const {
  client::LinkState state{.silent = false};
  if (at_ns_ != 0) {
    state.frame_age = client::Duration(0);
    state.calibration_age = has_calibration_ ? std::optional(client::Duration(0)) : std::nullopt;
    const std::uint64_t health = playback_.health_at_ns();
    if (playback_.health() && health <= at_ns_) {
      state.health_age = std::chrono::nanoseconds(at_ns_ - health);
    }
  }
  return state;
}

}  // namespace stof::lib
