#include "app/view_stream.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <array>

#include "app/views.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::app {

ViewStream::ViewStream(int descriptor, std::string name, const Camera& defaults)
    : name_(std::move(name)), defaults_(defaults) {
  if (pipe(stop_) != 0)
    throw RunError("no pipe can be made to read views", "too many files are open: see ulimit -n");
  thread_ = std::thread([this, descriptor] { read(descriptor); });
}

ViewStream::~ViewStream() {
  close(stop_[1]);
  thread_.join();
  close(stop_[0]);
}

void ViewStream::read(int descriptor) {
  std::string text;
  while (true) {
    std::array<pollfd, 2> wait{{{descriptor, POLLIN, 0}, {stop_[0], POLLIN, 0}}};
    if (poll(wait.data(), wait.size(), -1) < 0) continue;
    if (wait[1].revents != 0) return;
    std::array<char, 4096> chunk;
    const auto bytes = ::read(descriptor, chunk.data(), chunk.size());
    if (bytes > 0) text.append(chunk.data(), static_cast<std::size_t>(bytes));
    if (bytes <= 0 && !text.empty()) text += '\n';
    for (auto end = text.find('\n'); end != std::string::npos; end = text.find('\n')) {
      take_line(text.substr(0, end));
      text.erase(0, end + 1);
    }
    if (bytes > 0) continue;
    const std::lock_guard lock(mutex_);
    ended_ = true;
    return;
  }
}

void ViewStream::take_line(const std::string& line) {
  const std::lock_guard lock(mutex_);
  ++line_;
  const auto first = line.find_first_not_of(" \t\r");
  if (!error_.empty() || first == std::string::npos || line[first] == '#') return;
  try {
    views_.push_back(parse_path(line, fmt::format("{}, line {}", name_, line_), defaults_).front());
  } catch (const InputError& e) {
    error_ = e.what();
  }
}

std::optional<Camera> ViewStream::next() {
  const std::lock_guard lock(mutex_);
  if (!views_.empty()) {
    const Camera view = views_.front();
    views_.pop_front();
    return view;
  }
  if (!error_.empty()) throw InputError(error_);
  return std::nullopt;
}

bool ViewStream::has_next() {
  const std::lock_guard lock(mutex_);
  return !views_.empty();
}

bool ViewStream::may_come() {
  const std::lock_guard lock(mutex_);
  return !views_.empty() || !ended_ || !error_.empty();
}

}  // namespace ringsplat::app
