#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "firmware/settings/fields/field.h"
#include "firmware/settings/settings.h"
#include "firmware/settings/text/fixed_text.h"
#include "firmware/settings/text/paged_writer.h"

// Settings as JSON, both ways. No heap.
namespace stof::settings {

inline constexpr std::size_t kWhyBytes = 240;
// Bounds every document that write_document() writes.
inline constexpr std::size_t kMostDocumentBytes = 4096;

// The fields of a text that are as the preset has them, because this version does not take what it
// says.
struct FellBack {
  Access access = Access::kRead;  // the least that may change all of them; kRead: there are none
  Text<64> path{};                // of the first that takes it
};

// Any bytes: a JSON object of some or all fields. All of its fields are changed in `settings`, or,
// where one is refused, nothing is and `why` says in one line which and what it takes.
// `named`: where not nullptr, the fields that the text names are added. `fell_back`: gets those.
// A field of depth.match that an earlier version took, but this one does not, is no refusal: it is
// as the preset has it, and `why` says so although all was well. Where such a field said "preset",
// there is nothing to say.
bool parse(std::span<const char> text, Settings& settings, PagedWriter& why,
           FieldSet* named = nullptr, FellBack* fell_back = nullptr) noexcept;

// One field by its path, as command lines have it: "streams.depth", "raw".
bool parse_field(std::string_view path, std::string_view value, Settings& settings,
                 PagedWriter& why) noexcept;

// Adds to such a line that a field of depth.match is as the preset has it, and why.
void note_fallback(std::string_view path, std::string_view cause, PagedWriter& note) noexcept;
inline constexpr std::string_view kNotInThisVersion = "not in this version";

// All fields, one a line.
void write_document(const Settings& settings, PagedWriter& out) noexcept;

// CRC-32C of that document: two sensors of one version with one fingerprint have the same settings.
std::uint32_t fingerprint(const Settings& settings) noexcept;

}  // namespace stof::settings
