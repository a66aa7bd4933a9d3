#pragma once

// The lab speaks of everything in the appliance's terms.
namespace stof::dsp {}  // namespace stof::dsp
namespace stof::lab {
using namespace dsp;  // NOLINT(google-build-using-namespace): the lab is made of its parts
}  // namespace stof::lab
