#include "firmware/program/reopener.h"

#include <optional>

namespace stof::firmware {

Reopener::Reopener(board::Board& board, DeviceLending& lending)
    : lending_(lending), thread_([&board, &lending] {
        while (const std::optional<board::Device> device = lending.wait_for_lent()) {
          static_cast<void>(board::reopen(board, *device));  // the loop finds out
          lending.give_back(*device);
        }
      }) {}

Reopener::~Reopener() {
  lending_.end();
  thread_.join();
}

}  // namespace stof::firmware
