#pragma once

#include <filesystem>
#include <string>

#include "dataset/image.h"
#include "firmware/wire/messages/enums.h"
#include "host/cli/image_copy.h"
#include "host/client/raw/raw_exposure.h"

namespace stof::host {

// Writes the pictures that there are into the folder, which is made where missing, named by the
// exposure's id: raw_0000000042_left.pgm and _right.pgm (8 bit), _pmd.pgm (16 bit, A0 to A3 below
// each other). Throws Failure.
void write_raw(const client::RawExposure& exposure, const std::filesystem::path& folder);

// The samples A0 to A3, which must be there.
dataset::Image<std::uint16_t> below_each_other(const client::RawExposure& exposure);

// "raw exposure 42 of frame 41: left 640x480, ...; edge 12.345678901 s, sequences 40 40 39".
std::string raw_exposure_line(const client::RawExposure& exposure);
// The counts, by cause.
std::string raw_line(const client::RawStatistics& statistics);
// Why none come; begins with ": ". to_do: against a link that is too slow, where the command can.
std::string raw_absence(wire::SubscribeResult refusal, const std::string& to_do = {});

}  // namespace stof::host
