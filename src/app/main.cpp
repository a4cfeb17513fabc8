#include "app/program.hpp"

int main(int argc, char** argv) { return ringsplat::app::run_program(argc, argv); }
