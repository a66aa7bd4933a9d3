#include <chrono>
#include <string>
#include <vector>

#include "host/cli/sensor_text.h"
#include "host/cli/view/frame_copy.h"
#include "host/cli/view/status_line.h"
#include "host/client/frame/point_cloud.h"
#include "host/client/printable.h"
#include "host/client/reassembler.h"
#include "tests/fuzz/fuzz_input.h"

// Datagrams to who runs `stof view`: whatever frames, events and health they make, the lines about
// them are one line each of printable text, and their figures are of this world.
namespace stof {
namespace {

constexpr std::size_t kMostPixels = 1 << 12;

class View {
 public:
  void look(client::Reassembler& reassembler, client::Time now) {
    while (const std::optional<client::Frame> frame = reassembler.take(now)) {
      look_at(*frame);
    }
    while (const auto event = reassembler.take_event()) {
      say(host::event_line(event->report));
    }
    if (reassembler.health()) {
      say(host::health_line(*reassembler.health()) + host::active_text(*reassembler.health()));
    }
    if (line_.due(now) || line_.pending()) {
      say(line_.line(now, reassembler.statistics(), {}));
    }
  }

 private:
  static void say(const std::string& text) { fuzz::require(client::printable(text) == text); }

  void look_at(const client::Frame& frame) {
    line_.count(frame);
    const double share = host::coverage(frame);
    fuzz::require(share >= 0 && share <= 1);
    const std::optional<double> latency = host::latency_ms(frame);
    fuzz::require(!latency || (*latency >= -60'000 && *latency <= 60'000));
    say(host::streams_line(frame));
    copy_.keep(frame);
    fuzz::require(copy_.frame().depth.width() == frame.depth.width());
    if (copy_.has_depth()) {
      fuzz::require(copy_.planes().high.pixels.size() == copy_.planes().depth.pixels.size());
    }
    static_cast<void>(client::point_cloud(frame, points_));
    client::cloud_points(frame, points_);
  }

  host::StatusLine line_;
  host::FrameCopy copy_;
  std::vector<client::Point> points_;
};

}  // namespace
}  // namespace stof

void stof::fuzz::run(std::span<const std::byte> input) {
  client::Reassembler reassembler({.max_pixels = kMostPixels});
  View view;
  client::Time now{};
  for_each_record(input, [&](const Record& record) {
    wire::DatagramBuffer space{};
    const bool seal = (record.flags & kSeal) != 0;
    now += std::chrono::milliseconds(20 * record.seconds());
    reassembler.push(seal ? sealed(record.bytes, space) : record.bytes, now);
    view.look(reassembler, now);
  });
  reassembler.expire(now + std::chrono::seconds(100));
  view.look(reassembler, now);
}
