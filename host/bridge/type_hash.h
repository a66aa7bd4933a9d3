#pragma once

#include <string>

#include "host/recording/mcap/records.h"

namespace stof::bridge {

// The version 1 hash of a type ("RIHS01_" and 64 hex digits), as ROS 2 Iron and later compute and
// compare it (REP 2016): SHA-256 of its description as JSON, without constants, comments and
// defaults. schema: ros2msg, complete with what it is made of; else empty. Of the types of ROS
// none has a bounded string or sequence here: they are refused, too.
std::string type_hash(const mcap::Schema& schema);

// "sensor_msgs::msg::dds_::Image_" of "sensor_msgs/msg/Image".
std::string dds_type_name(const std::string& ros_name);

}  // namespace stof::bridge
