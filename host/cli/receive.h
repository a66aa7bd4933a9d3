#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "host/client/control/control_client.h"
#include "host/client/receiver.h"

// How commands find a sensor and receive what it sends: `stof view`, `stof record`.
namespace stof::host {

struct ReceiveOptions {
  std::string sensor;  // what sensor_address() takes, to subscribe at; empty: listens
  // Where to listen, without a sensor alone; none: port 7560 at every interface.
  std::optional<std::uint16_t> port;  // 0: any free one
  std::optional<std::string> bind;
  double timeout_s = 5;                 // without a frame since the next one was due
  std::filesystem::path port_file;      // gets the port's number when it is open
  bool signed_streams = false;          // takes only what the sensor signs for this program
  std::string keys;                     // file of them; empty: this user's
  std::optional<std::uint32_t> device;  // number of the sensor; none: who is known there
  std::string key;  // id of the one that alone counts, of signed streams; empty: of those there are
  // What no flag changes; `device` takes the place of its number.
  client::ReassemblerOptions reassembler{};
};

// What keys are for beside signed streams.
enum class KeyUse : std::uint8_t { kSignedAlone, kPage };
// With which key, and whom to believe.
void add_key_flags(CLI::App& command, ReceiveOptions& options, KeyUse use = KeyUse::kSignedAlone);
// Where to listen.
void add_place_flags(CLI::App& command, ReceiveOptions& options);
// How long to wait, and with which key: of commands that always subscribe.
void add_subscription_flags(CLI::App& command, ReceiveOptions& options,
                            KeyUse use = KeyUse::kSignedAlone);
// SENSOR, which may be a recording, --json, and how it is subscribed: of commands that read.
void add_reading_flags(CLI::App& command, ReceiveOptions& options, bool& json);
// All of them but the sensor.
void add_receive_flags(CLI::App& command, ReceiveOptions& options,
                       KeyUse use = KeyUse::kSignedAlone);
// Where `sensor` is a recording, of which all is read: throws Failure where the command line has a
// flag that means a sensor.
void judge_reading_flags(const CLI::App& command, const std::string& sensor);
// Throws Failure where they contradict each other.
void judge_receive_options(const ReceiveOptions& options);

// Also completes `options`: the key file, and which sensor is meant. Asks for `raw` pictures, if
// for any. Throws Failure.
client::Receiver open_receiver(ReceiveOptions& options, const wire::RawRequest& raw = {});
// How documents of the sensor that is received are read: with --signed what it signs alone. Throws
// Failure.
client::ControlOptions reading_control(const ReceiveOptions& options);
void tell_port(const ReceiveOptions& options, const client::Receiver& receiver);

// Of whom a sensor takes how many (docs/WIRE.md, "Subscription").
inline constexpr const char* kPlacesText =
    "four, and three of one computer; a paired one keeps one of the four for who has a key of it";

// "UDP 192.168.1.20:7560".
std::string place_of(const client::Receiver& receiver);
// Why a subscription brings no frame, and what to do.
std::string silence_text(client::Receiver& receiver, std::optional<std::uint32_t> meant);
// The same, also of one that sends by itself.
std::string absence_text(client::Receiver& receiver, const ReceiveOptions& options);
// Why no frame came at all: "packets came, but no frame: ...".
std::string no_frame_text(client::Receiver& receiver, const ReceiveOptions& options);
// Why no more frames came, after some: ": its health comes, ..." or ", last health 2.1 s ago: ...".
// last: the clock of the last frame.
std::string ended_text(client::Receiver& receiver, const ReceiveOptions& options,
                       wire::ClockState last = wire::ClockState::kMonotonic);
// The line that says whose frames these are. A signature proves it, so that from now on it is the
// one that is meant there.
std::string first_frame_line(const ReceiveOptions& options, const client::Receiver& receiver,
                             std::uint32_t device);

}  // namespace stof::host
