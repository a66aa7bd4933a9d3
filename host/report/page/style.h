#pragma once

#include <string_view>

namespace stof::host {

// The style sheet of every page.
std::string_view style_sheet();

}  // namespace stof::host
