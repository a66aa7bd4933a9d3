#pragma once

#include <string>

#include "host/bridge/robot_feed.h"
#include "host/cli/receive.h"

// What a receiver knows of its sensor, as a robot's topics tell it (host/bridge/robot_feed.h).
namespace stof::host {

// When the frame came.
bridge::RobotFeed::Times times_of(const client::Frame& frame, const client::Receiver& receiver);

// How the link is, and what the sensor says of itself, unless it is too old to be told. trouble:
// why no frame comes, empty: they come.
bridge::RobotFeed::Link link_of(const client::Receiver& receiver, std::string trouble);

}  // namespace stof::host
