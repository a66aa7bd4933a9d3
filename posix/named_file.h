#pragma once

#include <expected>
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

}  // namespace stof::posix
