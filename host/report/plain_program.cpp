#include "host/report/plain_program.h"

#include <array>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

namespace stof::host {
namespace {

const char* name_of(lab::Method method) {
  switch (method) {
    case lab::Method::kWinnerTakesAll:
      return "wta";
    case lab::Method::kOrdered:
      return "dp";
    case lab::Method::kScanline:
      return "so";
    case lab::Method::kSemiGlobal:
      return "sgm";
  }
  return "";
}

const char* name_of(lab::Cost cost) {
  switch (cost) {
    case lab::Cost::kSad:
      return "sad";
    case lab::Cost::kSsd:
      return "ssd";
    case lab::Cost::kCensus5x5:
      return "census5x5";
    case lab::Cost::kCensus9x7:
      return "census9x7";
    case lab::Cost::kMixed:
      return "mixed";
  }
  return "";
}

std::string read_all(int file) {
  std::string text;
  std::array<char, 256> part{};
  for (ssize_t n = 0; (n = read(file, part.data(), part.size())) > 0;) {
    text.append(part.data(), static_cast<std::size_t>(n));
  }
  return text;
}

// What a program prints. None: it cannot be started, or ends with another code than 0.
std::optional<std::string> output_of(std::vector<std::string> words) {
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) {
    return std::nullopt;
  }
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words) {
    arguments.push_back(word.data());
  }
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions{};
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  posix_spawn_file_actions_addclose(&actions, ends[0]);
  posix_spawn_file_actions_addclose(&actions, ends[1]);
  pid_t child = 0;
  const int error = posix_spawn(&child, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[1]);
  std::string text = read_all(ends[0]);
  close(ends[0]);
  int status = 1;
  if (error != 0 || waitpid(child, &status, 0) != child || status != 0) {
    return std::nullopt;
  }
  return text;
}

}  // namespace

bool can_run(const std::filesystem::path& program) {
  return std::filesystem::is_regular_file(program) && access(program.c_str(), X_OK) == 0;
}

std::optional<PlainMatch> run_plain(const std::filesystem::path& program,
                                    const std::filesystem::path& folder,
                                    const lab::MatchParams& params, int runs) {
  const std::optional<std::string> line = output_of(
      {program.string(), folder.string(), std::to_string(runs), "method", name_of(params.method),
       "cost", name_of(params.cost), "block",
       std::to_string(params.block_width) + "x" + std::to_string(params.block_height), "prefilter",
       params.prefilter_cap ? std::to_string(*params.prefilter_cap) : "off"});
  if (!line) {
    return std::nullopt;
  }
  const nlohmann::json told = nlohmann::json::parse(*line, nullptr, false);
  if (!told.is_object() || !told.contains("ms") || !told["ms"].is_number() ||
      !told.contains("map") || !told["map"].is_number_unsigned()) {
    return std::nullopt;
  }
  return PlainMatch{.ms = told["ms"].get<double>(), .map = told["map"].get<std::uint64_t>()};
}

}  // namespace stof::host
