#pragma once

#include <string_view>

// The page, made by the build of page/ (page/bundle.py).
namespace stof::viewer {

extern const std::string_view kPage;        // HTML with its style and script
extern const std::string_view kPagePolicy;  // its Content-Security-Policy, which names both by hash
extern const bool kHasPage;                 // false: a page that says how to build it

}  // namespace stof::viewer
