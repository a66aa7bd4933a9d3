#include "host/cli/live/reception.h"

#include <chrono>
#include <utility>

#include "host/cli/failure.h"
#include "host/cli/live/frame_wait.h"
#include "host/cli/stop_signal.h"

namespace stof::host {

// NOLINTNEXTLINE(modernize-pass-by-value): by value the larger options of commands are sliced
Reception::Reception(const ReceiveOptions& options, Listener listener)
    : options_(options), listener_(std::move(listener)), receiver_(open_receiver(options_)) {
  stop_on_signals();
  tell_port(options_, receiver_);
}

void Reception::run(const std::function<bool()>& done, Awaited awaited) {
  constexpr std::chrono::milliseconds kLook{50};
  silent_ = false;
  const client::Time began = client::Time::clock::now();
  client::Time heard = began;
  std::uint64_t packets = 0;
  while (!asked_to_stop() && !done()) {
    take(receiver_.next(kLook));
    while (const std::optional<client::ToldEvent> event = receiver_.take_event()) {
      if (listener_.event) {
        listener_.event(event->report);
      }
    }
    const std::string change =
        teller_.look(receiver_.link(), receiver_.health(), client::Time::clock::now());
    if (!change.empty() && listener_.line) {
      listener_.line(change);
    }
    for (const LinkTeller::Change& one : teller_.changes()) {
      if (listener_.change) {
        listener_.change(one);
      }
    }
    // What is not the sensor's does not count: whoever sends it must not keep us waiting.
    const client::Statistics& all = receiver_.statistics();
    const std::uint64_t heard_of = all.packets() - all.not_signed - all.forged;
    const client::Time now = client::Time::clock::now();
    heard = std::exchange(packets, heard_of) != heard_of ? now : heard;
    const bool over = awaited == Awaited::kFrames
                          ? frames_stay_away(receiver_, began, options_.timeout_s, now)
                          : now - heard > std::chrono::duration<double>(options_.timeout_s);
    if (over) {
      silent_ = true;
      return;
    }
  }
}

void Reception::take(const Result<client::Frame>& frame) {
  if (!frame) {
    if (frame.error() == Status::kDeviceLost) {
      throw Failure(Exit::kFailure, "the socket failed: start again");
    }
    return;
  }
  if (!device_) {
    device_ = frame->origin.device_id;
    const std::string line = first_frame_line(options_, receiver_, *device_);
    if (listener_.line) {
      listener_.line(line);
    }
  }
  ++frames_;
  clock_ = frame->stamp.clock;
  if (listener_.frame) {
    listener_.frame(*frame);
  }
}

void Reception::fail() {
  if (frames_ == 0) {
    throw Failure(Exit::kFailure, place() + ": " + no_frame_text(receiver_, options_));
  }
  const bool alone = what_comes(receiver_.link()) == Comes::kHealthAlone;
  throw Failure(
      Exit::kFailure,
      place() + (alone ? ": no frame came any more after " : ": the sensor fell silent after ") +
          std::to_string(frames_) + " frames" + ended_text(receiver_, options_, clock_));
}

}  // namespace stof::host
