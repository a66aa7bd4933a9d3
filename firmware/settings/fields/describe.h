#pragma once

#include "firmware/settings/text/paged_writer.h"

// The table of settings as documents. No heap.
namespace stof::settings {

// The JSON Schema (draft 2020-12) of settings: every field may be left out.
void write_schema(PagedWriter& out) noexcept;
// The table of docs/SETTINGS.md (Markdown).
void write_table(PagedWriter& out) noexcept;
// One field per line, for a command line's help.
void write_usage(PagedWriter& out) noexcept;

}  // namespace stof::settings
