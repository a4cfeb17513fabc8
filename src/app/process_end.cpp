#include "app/process_end.hpp"

#include <signal.h>

#include <array>

#include "base/output_file.hpp"

namespace ringsplat::app {
namespace {

constexpr std::array handled{SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGXCPU, SIGPIPE};

extern "C" void remove_files_and_end(int number) {
  remove_unfinished_files();
  // Ends the process with the signal's exit status. A library's earlier handler might return if called
  // instead, as UCX's does.
  signal(number, SIG_DFL);
  raise(number);
}

}  // namespace

void prepare_for_signals() {
  signal(SIGXFSZ, SIG_IGN);
  struct sigaction action {};
  action.sa_handler = remove_files_and_end;
  sigfillset(&action.sa_mask);
  for (const int number : handled) {
    struct sigaction before {};
    sigaction(number, nullptr, &before);
    if (before.sa_handler != SIG_IGN) sigaction(number, &action, nullptr);
  }
}

}  // namespace ringsplat::app
