#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "firmware/wire/messages/health.h"
#include "host/bridge/exposure_clock.h"
#include "host/bridge/topics.h"
#include "host/client/frame/frame.h"
#include "host/client/statistics.h"

namespace stof::bridge {

// Where messages go.
class TopicSink {
 public:
  virtual ~TopicSink() = default;
  // Whether somebody reads it: else no message has to be made.
  virtual bool wanted(Topic topic) = 0;
  // False: it was refused.
  virtual bool publish(Topic topic, recording::Buffer&& message) = 0;
};

struct FeedOptions {
  std::string name_space = "stof";
  int cloud_step = 4;  // px, 1 to kMostCloudStep; 0: no cloud
  Mount mount{};
};

// What a sensor's frames, health and silence are in the topics of ROS 2. Each frame becomes
// messages once, when it came: nothing is repeated, and what did not arrive is 0. No clock and no
// socket.
class RobotFeed {
 public:
  RobotFeed(TopicSink& sink, FeedOptions options);

  struct Times {
    std::int64_t first_packet_ns = 0;  // by a clock that does not step
    std::optional<std::int64_t> round_trip_ns{};
    std::int64_t wall_offset_ns = 0;  // system time less that clock
  };
  // Image, CameraInfo and cloud of a frame. The last two take the calibration that the frame was
  // made with. Returns the stamp, in system time.
  std::int64_t show(const client::Frame& frame, const Times& times);

  // What is known of the sensor besides.
  struct Link {
    std::string place{};                         // of the sensor, or the file
    std::string trouble{};                       // empty: frames come
    std::optional<wire::HealthReport> health{};  // none: never came, or is too old to be told
    client::Statistics statistics{};
    bool recording = false;  // a file
  };
  // The state as diagnostics: once a second, and on change.
  void tell(const Link& link, std::int64_t wall_ns);
  // The static transforms. Once.
  void place_frames(std::int64_t wall_ns);

 private:
  void publish(Topic topic, recording::Buffer&& message);
  recording::DiagnosticStatus link_status(const Link& link) const;

  TopicSink& sink_;
  FeedOptions options_;
  FrameIds frames_;
  ExposureClock clock_;
  std::vector<client::Point> points_;
  std::optional<wire::FrameStamp> newest_;
  wire::Origin origin_{};
  std::optional<std::int64_t> bound_ns_;  // of the newest stamp
  std::uint64_t shown_ = 0;
  std::uint64_t without_calibration_ = 0;
  std::uint64_t refused_ = 0;
};

}  // namespace stof::bridge
