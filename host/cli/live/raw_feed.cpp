#include "host/cli/live/raw_feed.h"

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "firmware/wire/frame/raw_packets.h"
#include "host/cli/failure.h"
#include "host/cli/live/frame_wait.h"
#include "host/cli/view/raw_files.h"

namespace stof::host {
namespace {

using Clock = client::Time::clock;

wire::RawRequest request_of(const RawFeedOptions& what) {
  wire::RawRequest raw;
  raw.pictures = static_cast<std::uint8_t>(wire::kRawLeft | wire::kRawRight | wire::kRawWhole |
                                           (what.pmd ? wire::kRawPmd : 0));
  raw.every = what.every;
  return raw;
}

std::int64_t middle_ns(const wire::Window& first, const wire::Window& last) {
  return (first.begin_ns + last.end_ns) / 2;
}

RawShot shot_of(const client::RawExposure& exposure) {
  RawShot shot{.exposure = exposure.stamp.freshness,
               .left = copy_of(exposure.left),
               .right = copy_of(exposure.right),
               .pmd = {}};
  if (!exposure.pmd.front().empty()) {
    constexpr std::int64_t kNsPerUs = 1000;
    const wire::RawInfo& info = exposure.info;
    shot.pmd = below_each_other(exposure);
    shot.pmd_after_pair_us = static_cast<std::int32_t>(
        (middle_ns(info.pmd_exposures.front(), info.pmd_exposures.back()) -
         middle_ns(info.pair_exposures.front(), info.pair_exposures.front())) /
        kNsPerUs);
  }
  return shot;
}

// Of pictures of this size; none where the sensor tells none.
std::optional<dsp::Pinhole> lens_of(const wire::CalibrationPacket& told, int width, int height) {
  if (told.image_width == 0 || told.fx <= 0 || told.fy <= 0) {
    return std::nullopt;
  }
  const double px = static_cast<double>(width) / told.image_width / 65536;
  return dsp::Pinhole{.width = width,
                      .height = height,
                      .fx = px * told.fx,
                      .fy = px * told.fy,
                      .cx = px * told.cx,
                      .cy = px * told.cy};
}

}  // namespace

struct RawFeed::Parts {
  Parts(ReceiveOptions where, const RawFeedOptions& what)
      : options(std::move(where)),
        pmd(what.pmd),
        receiver(open_receiver(options, request_of(what))) {}

  // The thread.
  void run(const std::stop_token& stop) {
    if (const std::optional<std::string> why = receive(stop)) {
      give_up(*why);
    }
  }

  // Takes pictures until it is told to stop, or why there will be no more.
  std::optional<std::string> receive(const std::stop_token& stop) {
    constexpr std::chrono::milliseconds kLook{50};
    const std::chrono::duration<double> patience(options.timeout_s);
    const client::Time began = Clock::now();
    client::Time seen = began;
    while (!stop.stop_requested()) {
      const Result<client::Frame> frame = receiver.next(kLook);
      const bool failed = !frame && frame.error() == Status::kDeviceLost;
      const client::Time now = Clock::now();
      const bool seen_now = take_raw();
      seen = seen_now ? now : seen;
      if (failed) {
        return "the socket failed: start again";
      }
      if (frames_stay_away(receiver, began, options.timeout_s, now)) {
        return place_of(receiver) + ": " + silence();
      }
      if (std::optional<std::string> why = absence(now - seen, patience)) {
        return why;
      }
    }
    return std::nullopt;
  }

  // What stayed away with the frames.
  std::string silence() {
    const client::LinkState link = receiver.link();
    if (!link.frame_age) {
      return no_frame_text(receiver, options);
    }
    const bool alone = what_comes(link) == Comes::kHealthAlone;
    return (alone ? "no frame came any more" : "the sensor fell silent") +
           ended_text(receiver, options);
  }

  // Why there are no raw pictures, where none came for so long.
  std::optional<std::string> absence(client::Time::duration since,
                                     std::chrono::duration<double> patience) const {
    const wire::SubscribeResult refusal = receiver.raw_refusal();
    if (refusal == wire::SubscribeResult::kOk && since > patience && lacks_pmd()) {
      return place_of(receiver) +
             ": the sensor has no PMD camera: connect it, or name a sensor that has one";
    }
    // Who is denied them is so for good; another one's end some time.
    if (since > 2 * patience || refusal == wire::SubscribeResult::kRawDenied) {
      return place_of(receiver) + ": no raw pictures came" + raw_absence(refusal);
    }
    return std::nullopt;
  }

  // Whether a PMD camera is asked for and the sensor's calibration knows none.
  bool lacks_pmd() const {
    return pmd && receiver.calibration() && receiver.calibration()->pmd_width == 0;
  }

  bool take_raw() {
    bool any = false;
    while (const std::optional<client::RawExposure> exposure = receiver.take_raw()) {
      if (!exposure->complete() || exposure->left.empty()) {
        continue;
      }
      RawShot shot = shot_of(*exposure);
      const std::lock_guard lock(mutex);
      newest = std::move(shot);
      if (receiver.calibration()) {
        lens = lens_of(*receiver.calibration(), newest->left.width, newest->left.height);
      }
      any = true;
      changed.notify_all();
    }
    return any;
  }

  void give_up(const std::string& line) {
    const std::lock_guard lock(mutex);
    failure = line;
    changed.notify_all();
  }

  ReceiveOptions options;
  bool pmd;                   // is asked for
  client::Receiver receiver;  // of the thread alone
  std::mutex mutex;           // of what follows
  std::condition_variable changed;
  std::optional<RawShot> newest;  // that nobody has taken
  std::optional<dsp::Pinhole> lens;
  std::string failure;
  std::jthread thread;
};

RawFeed::RawFeed(const ReceiveOptions& where, const RawFeedOptions& what)
    : parts_(std::make_unique<Parts>(where, what)) {
  Parts& parts = *parts_;
  parts.thread = std::jthread([&parts](const std::stop_token& stop) { parts.run(stop); });
}

RawFeed::~RawFeed() = default;

std::optional<RawShot> RawFeed::next(std::chrono::milliseconds patience) {
  Parts& parts = *parts_;
  std::unique_lock lock(parts.mutex);
  parts.changed.wait_for(lock, patience,
                         [&] { return parts.newest.has_value() || !parts.failure.empty(); });
  if (parts.newest) {
    return std::exchange(parts.newest, std::nullopt);
  }
  if (!parts.failure.empty()) {
    throw Failure(Exit::kFailure, parts.failure);
  }
  return std::nullopt;
}

std::optional<dsp::Pinhole> RawFeed::told_lens() const {
  const std::lock_guard lock(parts_->mutex);
  return parts_->lens;
}

}  // namespace stof::host
