#include "base/log.hpp"

#include <string>
#include <vector>

#include "support/catch.hpp"

using namespace ringsplat;

TEST_CASE("log lines of every level go to a sink while there is one") {
  std::vector<std::pair<LogLevel, std::string>> lines;
  set_log_sink([&](LogLevel level, const std::string& text) { lines.emplace_back(level, text); });
  log_debug("{}", 1);
  log_warning("bell\a");
  set_log_sink({});
  log_debug("to stderr");
  REQUIRE(lines.size() == 2);
  CHECK(lines[0] == std::pair(LogLevel::debug, std::string("1")));
  CHECK(lines[1].first == LogLevel::warning);
  CHECK(lines[1].second.find('\a') == std::string::npos);
}

TEST_CASE("a sink may only listen, and write lines as without it") {
  std::vector<std::string> heard;
  set_log_sink([&](LogLevel level, const std::string& text) {
    log_to_stderr(level, text);
    heard.push_back(text);
  });
  log_warning("a warning of a test");
  set_log_sink({});
  log_warning("nobody listens to this test");
  CHECK(heard == std::vector<std::string>{"a warning of a test"});
}
