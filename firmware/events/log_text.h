#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "firmware/events/events.h"
#include "firmware/settings/text/paged_writer.h"

// Text from what the loop recorded. Runs beside the loop, never in it.
namespace stof::firmware {

// One line without its end, at most kMostLine characters. Takes no memory: what the system refuses
// while the sensor runs costs no line.
inline constexpr std::size_t kMostLine = 200;
void describe(const Event& event, settings::PagedWriter& out) noexcept;

// How many threads compute, of those there are, and why not more.
std::string threads_text(int threads, int there);

// One line: what the loop's thread asked of the heap, while so many edges went out.
std::string heap_text(std::uint64_t own, std::uint64_t libraries, std::uint64_t edges);

// One line of totals: for the end.
std::string summary(const Counters& counters);

// One line: mean and longest time of each stage of a frame. Publishing is paced, not busy.
std::string stage_times(const Counters& counters);

}  // namespace stof::firmware
