#include "host/cli/live/reception.h"

#include <chrono>
#include <utility>

#include "host/cli/failure.h"
#include "host/cli/stop_signal.h"
#include "host/cli/view/status_line.h"

namespace stof::host {

// NOLINTNEXTLINE(modernize-pass-by-value): by value the larger options of commands are sliced
Reception::Reception(const ReceiveOptions& options, Listener listener)
    : options_(options), listener_(std::move(listener)), receiver_(open_receiver(options_)) {
  stop_on_signals();
  tell_port(options_, receiver_);
}

void Reception::run(const std::function<bool()>& done) {
  constexpr std::chrono::milliseconds kLook{50};
  silent_ = false;
  client::Time heard = client::Time::clock::now();
  std::uint64_t packets = 0;
  while (!asked_to_stop() && !done()) {
    take(receiver_.next(kLook));
    while (const std::optional<wire::EventReport> event = receiver_.take_event()) {
      if (listener_.event) {
        listener_.event(*event);
      }
    }
    const std::string change =
        teller_.look(receiver_.link(), receiver_.health(), client::Time::clock::now());
    if (!change.empty() && listener_.line) {
      listener_.line(change);
    }
    // What is not the sensor's does not count: whoever sends it must not keep us waiting.
    const client::Statistics& all = receiver_.statistics();
    const std::uint64_t heard_of = all.packets() - all.not_signed - all.forged;
    const client::Time now = client::Time::clock::now();
    heard = std::exchange(packets, heard_of) != heard_of ? now : heard;
    if (now - heard > std::chrono::duration<double>(options_.timeout_s)) {
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
  if (listener_.frame) {
    listener_.frame(*frame);
  }
}

void Reception::fail() {
  const bool heard = receiver_.statistics().packets() != 0;
  std::string why;
  if (frames_ != 0) {
    why = ": the sensor fell silent after " + std::to_string(frames_) + " frames, last health " +
          age_text(receiver_.link().health_age) + " ago: check that it runs, and the network";
  } else {
    why = std::string(heard ? ": packets came, but no frame" : ": no packet came") +
          (options_.sensor.empty() ? ": start stofd with --to, or check the network"
                                   : silence_text(receiver_, options_.device)) +
          (heard ? "; " + summary_line(receiver_.statistics()) : "");
  }
  throw Failure(Exit::kFailure, place() + why);
}

}  // namespace stof::host
