#pragma once

#include <string_view>

#include "firmware/settings/settings.h"
#include "firmware/settings/settings_server.h"
#include "firmware/settings/text/paged_writer.h"
#include "hal/store.h"

namespace stof::settings {

// The settings that a start begins with: those in the store, fields that it does not name at their
// defaults; the defaults where nothing was ever saved. A document that cannot be used (damaged, of
// a later version, not for this sensor) is set aside, the defaults hold, and `line` says so in one
// line that begins with `place`, such as the file's name. limits: nullptr: are not asked. Fields
// that this version does not take any more are as the preset has them: `line` names them, and
// *fell_back becomes true.
Settings load_settings(hal::Store& store, std::string_view place, Limits* limits, PagedWriter& line,
                       bool* fell_back = nullptr) noexcept;

}  // namespace stof::settings
