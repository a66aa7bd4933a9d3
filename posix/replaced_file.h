#pragma once

#include <cstddef>
#include <span>
#include <string>

#include <sys/types.h>

namespace stof::posix {

// Gives a file new contents as a whole: whatever happens meanwhile, also that the power goes, it
// has those of before or these. They are in `file` + ".new" first, which has `mode` from its first
// byte. 0 or an errno: then the file is as it was. A file that is a link, a pipe or a device is
// written in place, without that promise. Blocks until the medium has it.
int replace_file(const std::string& file, std::span<const std::byte> bytes, mode_t mode);

}  // namespace stof::posix
