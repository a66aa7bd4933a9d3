#pragma once

#include <expected>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/client/error.h"
#include "posix/fd.h"

// Files that a user alone may read and write. All errors are one line, with what to do.
namespace stof::client {

std::unexpected<OpenError> refuse_file(Status status, const std::string& file,
                                       std::string_view what);

// Waits until no other program of the user changes the file: `file`.lock, open; the lock goes with
// it. Makes the folder where there is none. kTimeout: one holds it for two seconds; kDeviceError.
std::expected<posix::Fd, OpenError> lock_own_file(const std::string& file);

// At most `most` bytes and one, wiped by the caller where they are secrets; none: there is no such
// file. kDeviceError: it cannot be read, is another user's, or others may read it (`shared` says
// what to do about that) or replace it.
std::expected<std::optional<std::vector<char>>, OpenError> read_own_file(const std::string& file,
                                                                         std::size_t most,
                                                                         std::string_view shared);

// Replaces the file as a whole, with its folder where there is none; mode 0600 from its first byte.
// kDeviceError.
std::expected<void, OpenError> write_own_file(const std::string& file, std::span<const char> text);

}  // namespace stof::client
