#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "host/client/control/control_client.h"

// What SENSOR names, in every command that takes one: a sensor that is reached by its address, a
// sensor near that is known by its serial number or name, or a recorded file.
namespace stof::host {

// The command reads a file in the sensor's place: a regular file of that name is there, or the text
// has a slash or ends with .mcap, as no sensor's does.
bool is_recorded(const std::string& sensor);

// HOST[:PORT] of what a user calls a sensor. What has a dot or a colon is an address already, and
// so is localhost. Any other word is looked for among the sensors near, by serial number and by
// name, for 3 s, and asked there itself (confirm_sensor.h); where none has it, it is a host's name.
// Looked for once in a program's life. Whoever answers to a number or a name may lie: what proves
// a sensor is its key alone.
// Throws Failure, bad input, where two sensors have that number or name, or nothing has, and where
// it is a recording or a folder; code 1 where it is reached by broadcast alone.
std::string sensor_address(const std::string& called);

// The device number that a word names which is a serial number: these are the same, the latter in 8
// hexadecimal digits. So no other sensor is asked by it, whoever announces what, and no name is
// looked for that reads so.
std::optional<std::uint32_t> serial_device(const std::string& called);

// That of the sensor which was found as sensor_address() finds it; none: an address, a
// host, or nothing at all.
std::optional<std::uint32_t> found_device(const std::string& called);

// It was found by its name.
bool is_sensor_name(const std::string& called);

// The same, open for requests: also to a sensor that is reached by broadcast alone
// (client::open_link_transport()).
std::unique_ptr<client::ControlTransport> open_sensor(const std::string& called);

}  // namespace stof::host
