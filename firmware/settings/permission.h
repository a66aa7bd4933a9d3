#pragma once

#include "firmware/control/access.h"
#include "firmware/settings/settings.h"
#include "firmware/settings/text/paged_writer.h"

namespace stof::settings {

using firmware::Access;

// Whether somebody with that access may make `next` of `active`: each field that differs has a
// least access of its own (Field::access), and all but the admin stay within the limits that are
// active. false: `why` says which field and what it takes.
bool permitted(const Settings& active, const Settings& next, Access access,
               PagedWriter& why) noexcept;

// Says in one line that `what` takes more than they have. Returns false.
bool deny(std::string_view what, Access access, Access least, PagedWriter& why) noexcept;

}  // namespace stof::settings
