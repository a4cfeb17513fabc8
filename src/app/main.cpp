#include "app/commands.hpp"
#include "base/lack_of_memory.hpp"

int main(int argc, char** argv) {
  ringsplat::prepare_for_lack_of_memory();
  return ringsplat::app::run_program(argc, argv);
}
