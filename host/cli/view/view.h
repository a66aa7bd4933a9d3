#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "host/client/receiver.h"
#include "host/picture/colour_scale.h"

namespace stof::host {

struct ViewOptions {
  std::string sensor;                         // HOST[:PORT] to subscribe at; empty: listens
  std::uint16_t port = client::kDefaultPort;  // 0: any free one
  std::string bind = "0.0.0.0";
  std::uint64_t frames = 0;             // 0: until SIGINT or SIGTERM
  double timeout_s = 5;                 // without any packet
  std::filesystem::path out;            // empty: no files
  std::filesystem::path truth;          // PFM, Z in metres, read when the first frame is there
  std::filesystem::path port_file;      // gets the port's number when it is open
  bool signed_streams = false;          // takes only what the sensor signs for this program
  std::string keys;                     // file of them; empty: this user's
  std::optional<std::uint32_t> device;  // number of the sensor; none: who is known there
  std::string key;  // id of the one that alone counts, of signed streams; empty: of those there are
  ColourScale scale;
  // Raw pictures to ask the sensor for: none, unless some are named. Written to `out`.
  wire::RawRequest raw;
  std::uint64_t raw_count = 0;  // end after so many whole exposures; 0: as `frames` says
};

// `stof view`: receives, prints a line a second and a summary, leaves pictures of the newest
// complete frame, and those of every raw exposure. Throws Failure.
void view(const ViewOptions& options);

}  // namespace stof::host
