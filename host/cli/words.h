#pragma once

#include <span>
#include <string>
#include <string_view>

#include <CLI/CLI.hpp>

namespace stof::host {

// What somebody meant who mistyped a word: the nearest of `known`, by letters that are missing, too
// many, wrong or exchanged, up to a third of the word. Empty: none is near.
std::string nearest_word(std::string_view word, std::span<const std::string> known);

// Refuses commands and flags that there are not, and names the nearest. Before the command line is
// parsed, so that --help behind one hides nothing. Throws Failure, bad input.
void judge_words(const CLI::App& app, std::span<char* const> words);

}  // namespace stof::host
