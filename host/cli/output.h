#pragma once

#include <filesystem>
#include <string>

// What commands leave: lines on stdout, files and folders. Found wrong before anything is asked of
// a sensor, where that can be known.
namespace stof::host {

// Prints the line and sends it on at once. Throws Failure, code 1, where nobody can read it: a full
// disk, a reader that has gone.
void say(const std::string& line);
// The same for a text that has its ends of lines.
void say_text(const std::string& text);
// A line on stderr, at once: where stdout holds JSON, what nobody should learn at its end only.
void say_aside(const std::string& line);

// Why what was to be printed could not be, and what to do, by errno.
const char* unwritten_text(int error) noexcept;

// Throws Failure, code 1, where stdout takes nothing at all (/dev/full, closed). A disk that fills
// up later shows when it does.
void need_output();

// The folder is there and can be written to, or can be made: nothing is made. Throws Failure, bad
// input; flag: that named it, such as "--out".
void need_folder(const std::filesystem::path& folder, const char* flag);

// The file can be written: a regular file or a character device, or nothing in such a folder.
// Throws Failure, bad input.
void need_file(const std::filesystem::path& file, const char* flag);

}  // namespace stof::host
