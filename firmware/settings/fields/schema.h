#pragma once

#include <string>

#include "firmware/settings/text/paged_writer.h"

// The table of settings as documents.
namespace stof::settings {

// The JSON Schema (draft 2020-12) of settings: every field may be left out. No heap.
void write_schema(PagedWriter& out) noexcept;

// The same, for start.
std::string settings_schema();
// The tables of docs/SETTINGS.md (Markdown): fields and presets.
std::string settings_tables();

}  // namespace stof::settings
