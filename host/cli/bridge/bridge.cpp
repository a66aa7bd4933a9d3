#include "host/cli/bridge/bridge.h"

#include <algorithm>
#include <cstdlib>
#include <sstream>

#include "host/bridge/block_cloud.h"
#include "host/bridge/dds/publisher.h"
#include "host/bridge/topics.h"
#include "host/cli/bridge/ros2.h"
#include "host/cli/failure.h"
#include "host/cli/help_text.h"
#include "host/cli/sensor/find_sensor.h"

namespace stof::host {
namespace {

// Domains beyond have ports of the system, or none.
constexpr std::uint32_t kMostDomain = 232;

// "base_link:0.2,0,0.3" or with roll, pitch and yaw behind it.
bridge::Mount mount_of(const std::string& text) {
  bridge::Mount mount;
  if (text.empty()) {
    return mount;
  }
  const auto bad = [&] {
    return Failure(Exit::kBadInput, "--mount " + text +
                                        ": is not PARENT:X,Y,Z or PARENT:X,Y,Z,ROLL,PITCH,YAW "
                                        "(metres, radians)");
  };
  const std::size_t colon = text.find(':');
  mount.parent = text.substr(0, colon);
  if (colon == std::string::npos || !bridge::good_namespace(mount.parent)) {
    throw bad();
  }
  std::vector<double> numbers;
  std::istringstream from(text.substr(colon + 1));
  for (double number = 0; from >> number;) {
    numbers.push_back(number);
    if (from.peek() == ',') {
      from.get();
    } else {
      break;
    }
  }
  const bool whole = from.peek() == std::istringstream::traits_type::eof();
  if (!whole || (numbers.size() != 3 && numbers.size() != 6)) {
    throw bad();
  }
  std::copy_n(numbers.begin(), 3, mount.translation_m.begin());
  if (numbers.size() == 6) {
    std::copy_n(numbers.begin() + 3, 3, mount.roll_pitch_yaw.begin());
  }
  return mount;
}

// ROS 2 programs are told their domain so.
std::uint32_t domain_of_environment() {
  const char* const text = std::getenv("ROS_DOMAIN_ID");  // NOLINT: before there are threads
  if (text == nullptr || *text == '\0') {
    return 0;
  }
  std::istringstream from(text);
  std::uint32_t domain = 0;
  if (!(from >> domain) || from.peek() != std::istringstream::traits_type::eof() ||
      domain > kMostDomain) {
    throw Failure(Exit::kBadInput,
                  "ROS_DOMAIN_ID is '" + std::string(text) + "': give a number from 0 to 232");
  }
  return domain;
}

void judge(const BridgeOptions& options) {
  judge_receive_options(options);
  if (!bridge::good_namespace(options.name_space)) {
    throw Failure(Exit::kBadInput, "--namespace " + options.name_space +
                                       ": words of letters, digits and _ that begin with no "
                                       "digit, with / between them");
  }
  if (options.loop && !is_recorded(options.sensor)) {
    throw Failure(Exit::kBadInput, "--loop: is for a recording");
  }
}

}  // namespace

void add_bridge(CLI::App& app, BridgeOptions& options) {
  CLI::App& all = *app.add_subcommand("bridge", "Pass depth on as a robot's middleware has it");
  all.require_subcommand(1);
  CLI::App& command = *all.add_subcommand(
      "ros2", "Publish depth as ROS 2 topics over DDS; ROS 2 need not be installed here");
  show_example(
      command, "stof bridge ros2 192.168.1.20 --namespace front",
      "Runs until it is interrupted; a sensor that is away is waited for, and diagnostics say so. "
      "CYCLONEDDS_URI configures Cyclone DDS, as usual.\n"
      "Ends with 0 (interrupted, or the recording is over), 1 (DDS cannot be used) or 2 (bad "
      "input).");
  command
      .add_option("SENSOR", options.sensor,
                  std::string(kSensorOrFile) + "; '-': listen for a sensor that sends here")
      ->required()
      ->check(not_empty());
  command
      .add_option("--namespace", options.name_space,
                  "Of the topics and, with _ for /, of the frames: another one for each sensor")
      ->capture_default_str();
  auto* const domain =
      command.add_option("--domain", options.domain, "DDS domain; without: ROS_DOMAIN_ID, or 0")
          ->check(CLI::Range(0U, kMostDomain));
  command
      .add_option("--cloud-step", options.cloud_step,
                  "Side of the block of pixels that a point of the cloud is of; 0: no cloud")
      ->check(CLI::Range(0, bridge::kMostCloudStep))
      ->capture_default_str();
  command
      .add_option(
          "--fragment", options.fragment,
          "Bytes of a message that are sent again as one; 60000 saves time where all readers are "
          "on this computer")
      ->check(CLI::Range(bridge::kLeastFragment, bridge::kMostFragment))
      ->capture_default_str();
  command
      .add_option("--datagram", options.datagram,
                  "Bytes of a datagram at most; 1400, which is never cut into IP fragments, where "
                  "the network loses more than one packet of a thousand")
      ->check(CLI::Range(bridge::kNetworkDatagram, bridge::kMostDatagram))
      ->capture_default_str();
  command.add_option("--mount", options.mount,
                     "PARENT:X,Y,Z[,ROLL,PITCH,YAW], metres and radians: where the sensor is in "
                     "the frame PARENT, for /tf_static");
  command.add_flag("--loop", options.loop, "Begin a recording again when it is over");
  command.add_option("--times", options.times,
                     "File that gets a line a frame: number, stamp, when its last packet came and "
                     "when it was handed to DDS, ns of system time; to measure");
  add_place_flags(command, options);
  add_key_flags(command, options);
  command.callback([&options, domain] {
    if (options.sensor == "-") {
      options.sensor.clear();
    }
    if (domain->empty()) {
      options.domain = domain_of_environment();
    }
    judge(options);
    bridge_ros2(options, mount_of(options.mount));
  });
}

}  // namespace stof::host
