#pragma once

#include <cstdint>

#include "hal/emu/scenes/rig.h"
#include "hal/emu/scenes/scene.h"

namespace stof::hal::emu {

struct Room {
  Scene scene;
  Rig rig;
};

// A closed room of random size with 5 to 10 random objects in it, and a random rig that looks at
// them; each seed another one, the same on every machine. Everything seen is 0.8 to 7 m away
// and no camera is inside of an object. Walls and objects have noise of several periods, stripes,
// checks or one colour; some reflect infrared as they reflect light.
// The rig: 640x480, 52 to 61 degrees wide, baseline 0.08 to 0.16 m; a 176x144 PMD camera at 20
// MHz, up to 9 cm beside the middle of the baseline and turned by up to 2 degrees about each axis,
// whose 14 bits hold white at 0.8 m.
Room random_room(std::uint32_t seed);

}  // namespace stof::hal::emu
