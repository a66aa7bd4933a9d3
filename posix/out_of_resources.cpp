#include "posix/out_of_resources.h"

#include <cstdlib>
#include <cstring>
#include <exception>
#include <initializer_list>
#include <new>

#include <cxxabi.h>
#include <unistd.h>

namespace stof::posix {
namespace {

constexpr int kExitFailure = 1;
const char* program_name = "";

// Allocates nothing.
[[noreturn]] void end(const char* line) noexcept {
  for (const char* const text : {program_name, ": ", line, "\n"}) {
    static_cast<void>(!write(STDERR_FILENO, text, std::strlen(text)));
  }
  _exit(kExitFailure);
}

void without_memory() { end("the system refuses memory: end other programs, or raise its limits"); }

[[noreturn]] void terminate() {
  const std::type_info* const type = abi::__cxa_current_exception_type();
  // What std::thread throws, by its name: there is no type information here to compare.
  if (type != nullptr && std::strcmp(type->name(), "St12system_error") == 0) {
    end("the system refuses a thread: end other programs, or raise its limits");
  }
  std::abort();
}

}  // namespace

void end_in_one_line_when_refused(const char* program) noexcept {
  program_name = program;
  std::set_new_handler(&without_memory);
  std::set_terminate(&terminate);
}

}  // namespace stof::posix
