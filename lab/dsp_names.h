#pragma once

// The lab calls what is dsp's by its plain name.
namespace stof::dsp {}  // namespace stof::dsp
namespace stof::lab {
using namespace dsp;  // NOLINT(google-build-using-namespace): the lab is made of its parts
}  // namespace stof::lab
