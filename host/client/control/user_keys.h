#pragma once

#include <expected>
#include <functional>
#include <optional>
#include <string>

#include "firmware/wire/keys/key_table.h"
#include "host/client/error.h"

// The keys that a user of this machine has of his sensors, in one file of his own (docs/WIRE.md,
// "The key file").
namespace stof::client {

// $XDG_CONFIG_HOME/stof/keys, else $HOME/.config/stof/keys; empty: neither is set.
std::string user_keys_file();

// No file: no keys. kDeviceError: it cannot be read, is another user's, or others may read it or
// replace it; kCorrupt: damaged, or of a later version. One line, with what to do.
std::expected<wire::KeyTable, OpenError> read_user_keys(const std::string& file);

// Reads it again whenever it is called; none: it cannot be read.
std::function<std::optional<wire::KeyTable>()> rereading(const std::string& file);

// Replaces the file as a whole, with its folder where there is none; mode 0600 from its first byte.
// kDeviceError.
std::expected<void, OpenError> write_user_keys(const std::string& file, const wire::KeyTable& keys);

// Gives the file other keys, made of those that are in it, while no other program of the user does
// the same: waits for those (`file`.lock). kTimeout: one holds it for two seconds; and as the
// others, and as `change`.
using ChangeKeys = std::function<std::expected<wire::KeyTable, OpenError>(const wire::KeyTable&)>;
std::expected<void, OpenError> update_user_keys(const std::string& file, const ChangeKeys& change);

// Adds a key as the newest. One of the same sensor and id goes: it has another secret now. All
// others stay: two sensors may have one number. kTooLarge, kInvalidArgument: another sensor's has
// that id; and as update_user_keys().
std::expected<void, OpenError> add_user_key(const std::string& file, const wire::Key& key);

}  // namespace stof::client
