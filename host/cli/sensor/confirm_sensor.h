#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "host/discovery/found_sensors.h"

// What is told to a whole link anybody on it may have made up, and sent from any address. So
// whoever is found by a number or a name is asked himself, alone, at the address that he is found
// at.
namespace stof::host {

// Where the sensor itself says that it is this one, and that it is called so: HOST:PORT; where
// nobody answers at once, where it was heard. fits: whether a sensor is called as the user said.
// Says so on stderr where addresses of two network cards answer. Throws Failure, bad input, where
// others answer.
std::string confirmed_endpoint(const std::string& called, const client::FoundSensor& sensor,
                               const std::function<bool(const client::FoundSensor&)>& fits);

// Those of several found ones that are there now: they answer when all of the link are asked once
// more, and where packets go to them alone they say there that they are this one. One that has
// started again at another port was two a moment ago. Blocks for a second, or a few.
std::vector<client::FoundSensor> still_there(
    std::span<const client::FoundSensor> found,
    const std::function<bool(const client::FoundSensor&)>& fits);

// Where all of a link may answer, what was heard is all there is: two names are not one sensor's.
// Throws Failure, bad input.
void refuse_two_names(const client::FoundSensor& sensor);

}  // namespace stof::host
