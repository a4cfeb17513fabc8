#pragma once
#include <fcntl.h>
#include <unistd.h>

#include <cstdio>
#include <string>

#include "formats/files.hpp"

/// Redirects stderr to a file while it lives.
class CapturedLog {
 public:
  CapturedLog() : before_(::dup(STDERR_FILENO)) {
    std::fflush(stderr);
    const int file = ::open((folder_ / "log").c_str(), O_CREAT | O_WRONLY | O_TRUNC | O_APPEND, 0600);
    ::dup2(file, STDERR_FILENO);
    ::close(file);
  }
  ~CapturedLog() {
    std::fflush(stderr);
    ::dup2(before_, STDERR_FILENO);
    ::close(before_);
  }
  CapturedLog(const CapturedLog&) = delete;
  CapturedLog& operator=(const CapturedLog&) = delete;

  std::string text() const {
    std::fflush(stderr);
    return files::slurp(folder_ / "log");
  }

 private:
  files::Folder folder_;
  int before_;
};
