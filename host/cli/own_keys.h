#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/cli/control_flags.h"
#include "host/cli/failure.h"
#include "host/client/control/control_client.h"
#include "host/client/control/known_sensors.h"

// What the commands that sign with a key of this user share.
namespace stof::host {

// The value, or Failure without it.
template <typename Expected>
auto value_or_end(Expected&& result) {
  if (!result) {
    throw Failure(Exit::kFailure, result.error().message);
  }
  if constexpr (!std::is_void_v<typename std::remove_cvref_t<Expected>::value_type>) {
    return std::move(*std::forward<Expected>(result));
  }
}

void need_crypto();  // throws Failure

client::ControlOptions timing(double timeout_s);

// Of commands that change something at one sensor, with the keys of the file; sensor: as the user
// calls it, empty with flags.serial. Throws Failure.
client::ControlOptions control_of(const std::string& file, const std::string& sensor,
                                  const ControlFlags& flags);

// To a sensor as the user calls it (open_sensor()), or by a line: one of the two. Throws Failure.
std::unique_ptr<client::ControlTransport> open_way(const char* command, const std::string& sensor,
                                                   const std::string& serial, unsigned baud);

// Of a sensor, the newest first. Two sensors may have one number. Throws Failure, bad input, where
// there is none.
std::vector<wire::Key> own_keys(const std::string& file, const wire::KeyTable& keys,
                                std::uint32_t device);

// Who is meant: by what the user says, by the serial number that he names it by, or by the key that
// was proven there. Throws Failure.
client::Meant meant_by(const std::string& file, const wire::KeyTable& keys,
                       const std::string& sensor, client::Asked asked);

// The same. Throws Failure where nobody knows which of several sensors is meant, too.
client::Meant meant_or_fail(const std::string& file, const wire::KeyTable& keys,
                            const std::string& sensor, const client::Asked& asked);

// Where a user calls a sensor by its name, which anybody may announce: reads it of whoever answers,
// signed where there is a key. Throws Failure, bad input, where it is another one.
void check_called(client::ControlClient& sensor, const std::string& called);
// The same over a way of its own, with these keys.
void check_called(const std::string& called, client::ControlOptions control,
                  const wire::KeyTable& keys);

// The number of the sensor that is meant, else of the only one.
std::uint32_t device_of(const client::Meant& meant);

// Keeps where a sensor was proven to be (client::remember_sensor()); a folder that cannot be
// written does not matter.
void remember_place(const std::string& key_file, const client::Place& place, std::uint32_t key_id);

// Behind the sensor's name. told: the text of an answer with result kUnknownKey.
std::string unknown_key_text(const std::string& told);

std::string id_text(const wire::Key& key);  // 8 hexadecimal digits
// Of the 8 hexadecimal digits of that flag; 0: no text. Throws Failure.
std::uint32_t key_id_of(const std::string& text, const char* flag = "--key");

// The user's key file where a flag names none.
std::string keys_file(const std::string& named);

}  // namespace stof::host
