#include "app/process_end.hpp"
#include "app/program.hpp"

int main(int argc, char** argv) {
  ringsplat::app::prepare_for_signals();
  return ringsplat::app::run_program(argc, argv);
}
