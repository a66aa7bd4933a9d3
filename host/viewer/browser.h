#pragma once

#include <string>

namespace stof::viewer {

// Opens the address in the user's browser where there is a desktop, by xdg-open, without a shell
// and without waiting. False: there is no desktop, or no xdg-open.
bool open_browser(const std::string& address);

}  // namespace stof::viewer
