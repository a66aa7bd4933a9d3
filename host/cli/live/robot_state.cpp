#include "host/cli/live/robot_state.h"

#include <chrono>
#include <utility>

#include "host/client/arrival_clock.h"

namespace stof::host {
namespace {

using std::chrono::duration_cast;
using std::chrono::nanoseconds;

// Health comes once a second; what is older says nothing of now.
constexpr std::chrono::milliseconds kHealthTold{2500};

}  // namespace

bridge::RobotFeed::Times times_of(const client::Frame& frame, const client::Receiver& receiver) {
  const client::ArrivalClock::Now now = client::ArrivalClock::now();
  bridge::RobotFeed::Times times{
      .first_packet_ns = duration_cast<nanoseconds>(frame.first_packet.time_since_epoch()).count(),
      .wall_offset_ns =
          duration_cast<nanoseconds>(now.wall - now.monotonic.time_since_epoch()).count()};
  if (const std::optional<client::Duration> way = receiver.round_trip()) {
    times.round_trip_ns = duration_cast<nanoseconds>(*way).count();
  }
  return times;
}

bridge::RobotFeed::Link link_of(const client::Receiver& receiver, std::string trouble) {
  bridge::RobotFeed::Link link{.place = place_of(receiver),
                               .trouble = std::move(trouble),
                               .statistics = receiver.statistics()};
  const client::LinkState state = receiver.link();
  if (state.health_age && *state.health_age < kHealthTold) {
    link.health = receiver.health();
  }
  return link;
}

}  // namespace stof::host
