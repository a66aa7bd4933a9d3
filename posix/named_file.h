#pragma once

#include <cstddef>
#include <expected>
#include <span>
#include <string>

#include "posix/fd.h"

// Files that somebody names, to be written. A folder that others write to may hold anything under a
// name: no link is followed, a pipe is not waited for. The folders on the way may be links.
namespace stof::posix {

// Opens `file` for writing, a regular file or a character device; it is made where missing, with
// the mode 0666 less the umask. empty: what it had is gone. Or an errno: ELOOP where it is a link,
// EISDIR, ENXIO where it is a pipe or something else.
std::expected<Fd, int> open_named_file(const std::string& file, bool empty);

// Makes `file`. Or an errno: EEXIST where something has the name, also a link that leads nowhere.
std::expected<Fd, int> create_named_file(const std::string& file);

// Gives it new contents as a whole: they are in a file of its own first, which takes its name, so
// that nobody reads a part of them, and a full disk leaves it as it was. It keeps its mode. Does
// not wait for the medium (replaced_file.h does). Where the folder lets nothing take the file's
// place, and for a character device, it is written in place, without that promise. 0 or an errno,
// as of open_named_file().
int replace_named_file(const std::string& file, std::span<const std::byte> bytes);

// All of them; false: errno says why not.
bool write_all(int fd, std::span<const std::byte> bytes);

}  // namespace stof::posix
