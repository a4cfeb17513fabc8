#include "app/frame_writer.hpp"

#include <utility>

#include "base/process.hpp"

namespace ringsplat::app {

FrameWriter::FrameWriter(std::function<void(FinishedFrame&&)> write) : write_(std::move(write)) {}

FrameWriter::~FrameWriter() { end(); }

void FrameWriter::end() {
  {
    const std::lock_guard lock(mutex_);
    no_more_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void FrameWriter::put(FinishedFrame&& frame) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return waiting_.size() < room || failure_; });
  if (failure_) std::rethrow_exception(failure_);
  if (!thread_.joinable()) thread_ = std::thread([this] { run(); });
  waiting_.push_back(std::move(frame));
  changed_.notify_all();
}

void FrameWriter::finish() {
  end();
  if (failure_) std::rethrow_exception(failure_);
}

void FrameWriter::run() {
  // Same as on the rendering thread, so that a file's bytes do not depend on the thread that writes it.
  flush_denormals();
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return !waiting_.empty() || no_more_; });
    if (waiting_.empty()) return;
    FinishedFrame frame = std::move(waiting_.front());
    waiting_.pop_front();
    changed_.notify_all();
    lock.unlock();
    std::exception_ptr failure;
    try {
      write_(std::move(frame));
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    if (!failure) continue;
    failure_ = failure;
    waiting_.clear();
    changed_.notify_all();
    return;
  }
}

}  // namespace ringsplat::app
