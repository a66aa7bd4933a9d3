#pragma once

#include <cstdint>
#include <expected>
#include <optional>
#include <string>
#include <string_view>

#include "firmware/wire/keys/key_table.h"
#include "host/client/error.h"

// Which of a user's sensors is where: a key proves that a sensor is one of his, and not that it is
// the one he asked for. So his programs remember which key was proven at which place, in a file
// beside that of his keys (docs/WIRE.md, "The file of places").
namespace stof::client {

// Where a sensor was proven to be.
struct Place {
  std::string_view named;    // what the user calls it, HOST[:PORT]
  std::string_view address;  // that this was, with its port
};

// Whom a program believes.
struct Meant {
  std::optional<std::uint32_t> device{};  // this sensor alone; none: whoever answers
  wire::KeyTable keys{};                  // and with these keys alone
  std::string doubt{};  // not empty: nobody knows which of several is meant, so nothing is signed;
                        // one line, which ends with "name the one that is meant"
};

// asked: the sensor that the user names by its number; else the one whose key was proven at
// `named`, HOST[:PORT], as he calls it; else at its address, for which it may block on a name
// server; else, where all his keys are of one sensor, whoever answers (who has no key of his proves
// nothing). Numbers may be given twice: where a key was proven only that one counts, but where
// `asked` is another sensor's. named: empty: a serial line. keys: all that the user has; what was
// proven with others is forgotten. Errors as read_own_file(); kCorrupt: no such file, or damaged.
std::expected<Meant, OpenError> meant_sensor(const std::string& key_file,
                                             const wire::KeyTable& keys, std::string_view named,
                                             std::optional<std::uint32_t> asked);

// The key was proven to be of the sensor there, and no other from now on. Writes only where that is
// news. Errors as meant_sensor(), and as write_own_file().
std::expected<void, OpenError> remember_sensor(const std::string& key_file,
                                               const wire::KeyTable& keys, const Place& place,
                                               std::uint32_t key_id);

// Another sensor than the one that is meant answers: what that may be, and what to do.
std::string other_sensor(std::uint32_t answers, std::uint32_t meant);

}  // namespace stof::client
