#pragma once

#include <expected>
#include <string>

#include "firmware/wire/keys/key_table.h"
#include "host/client/error.h"

// The keys that a user of this machine has of his sensors, in one file of his own (docs/WIRE.md,
// "The key file").
namespace stof::client {

// $XDG_CONFIG_HOME/stof/keys, else $HOME/.config/stof/keys; empty: neither is set.
std::string user_keys_file();

// No file: no keys. kDeviceError: it cannot be read, or others may read it; kCorrupt: damaged, or
// of a later version. One line, with what to do.
std::expected<wire::KeyTable, OpenError> read_user_keys(const std::string& file);

// Replaces the file as a whole, with its folder where there is none; mode 0600 from its first byte.
// kDeviceError.
std::expected<void, OpenError> write_user_keys(const std::string& file, const wire::KeyTable& keys);

// Adds a key. Other keys of that sensor go: it is the one that it has for this user now. kTooLarge,
// and as the others.
std::expected<void, OpenError> add_user_key(const std::string& file, const wire::Key& key);

}  // namespace stof::client
