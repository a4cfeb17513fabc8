#include "app/commands.hpp"
#include "program/process_end.hpp"

int main(int argc, char** argv) {
  ringsplat::app::ignore_file_size_signal();
  ringsplat::app::prepare_for_lack_of_memory();
  return ringsplat::app::run_program(argc, argv);
}
