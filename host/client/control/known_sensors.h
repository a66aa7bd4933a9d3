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

// What a user says of the sensor that he means.
struct Asked {
  std::optional<std::uint32_t> device{};  // its number, which it chose itself
  std::uint32_t key_id = 0;               // of a key of his: the one thing that nobody imitates
};

// The sensor of the key that is asked for, which alone counts then; else the number that is; else
// the one whose key was proven at `named`, HOST[:PORT], as the user calls it, a number also by its
// value; else, where all his keys are of one sensor, whoever answers (who has no key of his proves
// nothing). Names are never looked up for this: whoever answers for a name would choose the sensor.
// Numbers may be given twice: where a key was proven only that one counts, but where the number
// asked for is another one; two keys of one number, proven at several places, are of two sensors.
// named: empty: a serial line. keys: all that the user has; what was proven with others is
// forgotten. Errors as read_own_file(); kCorrupt: no such file, or damaged; kInvalidArgument: there
// is no such key, or it is of another number.
std::expected<Meant, OpenError> meant_sensor(const std::string& key_file,
                                             const wire::KeyTable& keys, std::string_view named,
                                             const Asked& asked);

// The key that was proven at `named`, likewise; 0: none.
std::expected<std::uint32_t, OpenError> key_proven_at(const std::string& key_file,
                                                      const wire::KeyTable& keys,
                                                      std::string_view named);

// The key was proven to be of the sensor there, and no other from now on. Writes only where that is
// news. Errors as meant_sensor(), and as write_own_file().
std::expected<void, OpenError> remember_sensor(const std::string& key_file,
                                               const wire::KeyTable& keys, const Place& place,
                                               std::uint32_t key_id);

// Another sensor than the one that is meant answers: what that may be, and what to do.
std::string other_sensor(std::uint32_t answers, std::uint32_t meant);

}  // namespace stof::client
