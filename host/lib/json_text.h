#pragma once

#include <optional>
#include <string_view>

// Parts of JSON texts that a sensor sent, found where they stand. Any bytes may come.
namespace stof::lib {

// The value of that name in an object, from its first byte to its last; none: `object` is none, or
// has none of that name before something that is not JSON.
std::optional<std::string_view> json_member(std::string_view object,
                                            std::string_view name) noexcept;

// The same of "depth.max_range_mm", one name within the other; before each name `between`, where it
// is not empty ("properties" in a schema).
std::optional<std::string_view> json_at(std::string_view object, std::string_view path,
                                        std::string_view between = {}) noexcept;

// The next item of an array, which is taken off its front; none: it has ended.
std::optional<std::string_view> json_next(std::string_view& array) noexcept;

// Without its quotes; what is no string as it is.
std::string_view json_string(std::string_view value) noexcept;

}  // namespace stof::lib
