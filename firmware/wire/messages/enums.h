// Made by scripts/wire_table.py of firmware/wire/messages.json: change that.
#pragma once

#include <cstdint>

namespace stof::wire {

// Enumerations hold what arrived: a value without a name is legal and means "newer than this code".
// It is ignored and counted, never an error.

enum class PacketType : std::uint8_t {
  kTile = 1,       // part of a frame: a run of pixels of one stream
  kFrameInfo = 2,  // part of a frame: its index 0
  kCalibration =
      64,        // once a second, with the number of the frame it was sent beside; index 0 of 1
  kHealth = 65,  // once a second and on change, also without frames; index 0 of 1
  kParity = 66,  // of a frame: its index counts groups; see "Parity"
  kEvent = 67,   // a condition that began or ended, when it did and once more a second later; index
                 // 0 of 1
  kAnnounce = 68,          // who and where the sensor is; answers a discover, and the beacon
  kSectors = 69,           // nearest obstacle by direction; on serial lines; index 0 of 1
  kSubscribe = 128,        // to the sensor: send me the streams, and go on for a lease
  kSubscribed = 129,       // answer to subscribe and unsubscribe
  kUnsubscribe = 130,      // to the sensor: stop
  kSettingsRequest = 132,  // to the sensor: read or change settings
  kSettingsAnswer = 133,   // answer to it
  kDiscover = 134,         // to the sensor, also by broadcast: who are you
};

enum class Stream : std::uint8_t {
  kNone = 0,    // outside tiles
  kDepth = 1,   // u16, quarter millimetres, Z in the rectified left camera; 0 = none
  kWidth = 2,   // u16, quarter millimetres, of the interval: the truth lies in depth - width / 2 ..
                // depth + width / 2 (95 percent); 0 where depth is none. A quarter of it is the
                // standard deviation
  kSource = 3,  // u8: where the depth comes from (bits 0 to 3, see "Sources") and why it was
                // resolved or is missing (bits 4 to 7, see "Causes")
  kDisparity =
      4,  // u16: 32768 + disparity in 1/16 px of the rectified left picture, stereo alone; 0 = none
  kPmdRaw = 5,    // u16: the four samples of the PMD camera as they came, A0 to A3 below each other
                  // (reference phase 0, 90, 180, 270 degrees): PMD width x 4 PMD height
  kGreyLeft = 6,  // u8: the left picture, rectified where the sensor rectifies
  kGreyRight = 7,  // u8: the right picture, likewise
  kCloud = 8,  // one point for each block of step x step pixels: of its pixels with a depth the one
               // whose near bound (depth - width / 2) is nearest
};

enum class Codec : std::uint8_t {
  kNone = 0,    // outside tiles
  kRaw16 = 1,   // two bytes a pixel
  kRaw8 = 2,    // one byte a pixel
  kRvl16 = 3,   // RVL of values of 16 bits, begun anew in each packet; see "RVL"
  kRvl8 = 4,    // RVL of values of 8 bits
  kPoints = 5,  // 8 bytes a point: x and y (i16, mm), depth and width (u16, quarter millimetres);
                // depth 0 = no point
};

enum class Health : std::uint8_t {
  kOk = 0,        // good
  kDegraded = 1,  // a minor or major condition is active
  kFault = 2,     // a critical condition is active
};

enum class ClockState : std::uint8_t {
  kMonotonic = 0,  // nanoseconds of the sensor's own clock, synchronised with nothing
  kEmulated = 1,   // an emulated rig's own time
};

enum class Severity : std::uint8_t {
  kInfo = 0,      // nothing to do
  kMinor = 1,     // the data are good, something wants attention
  kMajor = 2,     // the data are incomplete or less sure than usual; may heal by itself
  kCritical = 3,  // there are no data; may heal by itself
};

enum class Reaction : std::uint8_t {
  kNone = 0,   // go on
  kWatch = 1,  // go on, tell whoever maintains the robot
  kSlow = 2,   // slow down: rely on what arrives, but expect gaps
  kStop = 3,   // bring the robot to a safe stop: the sensor sees nothing
};

enum class SubscribeResult : std::uint8_t {
  kOk = 0,      // the streams come, for the lease
  kCookie = 1,  // repeat the request with this cookie
  kFull = 2,    // as many subscribers as the sensor takes: try again when one has left
  kEnded = 3,   // the subscription is over
};

enum class SettingsOperation : std::uint8_t {
  kGet = 0,  // read a document, from `offset` on
  kSet = 1,  // the text is a JSON object: changes those fields of the active settings, and nothing
             // if one of them is refused
  kStage =
      2,  // the same to the staged settings, which are the active ones until something is staged
  kCommit = 3,  // the staged settings become the active ones and are saved
  kRevert = 4,  // what is staged is forgotten
  kPreset = 5,  // the text is a preset's name: as set, with its fields
  kSave = 6,    // the active settings are those of the next start
  kReset = 7,   // as set, with every field's default
};

enum class SettingsDocument : std::uint8_t {
  kActive = 0,    // what the sensor runs with
  kStaged = 1,    // what commit would make active
  kSaved = 2,     // what the next start would use
  kDefaults = 3,  // what it would run with without any file
  kSchema = 4,    // the JSON Schema of all of these
};

enum class SettingsResult : std::uint8_t {
  kOk = 0,           // done; of get: the text is a part of the document
  kCookie = 1,       // repeat the request with this cookie
  kInvalid = 2,      // refused, nothing changed; the text says which field and what it takes
  kNotSaved = 3,     // active, but could not be saved; the text says why
  kUnsupported = 4,  // an operation or document this sensor does not know
  kBusy = 5,         // another request is being served: repeat
};

}  // namespace stof::wire
