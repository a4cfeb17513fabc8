#pragma once
// What every trace file must be, whatever was run.
#include <cmath>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "support/catch.hpp"

namespace ringsplat::test {

using TraceEvents = std::vector<nlohmann::json>;

inline std::int64_t nanoseconds(const nlohmann::json& microseconds) {
  return std::llround(microseconds.get<double>() * 1000);
}

/// Thread number → node name.
inline std::map<int, std::string> thread_names(const nlohmann::json& trace) {
  std::map<int, std::string> names;
  for (const auto& e : trace["traceEvents"])
    if (e["ph"] == "M" && e["name"] == "thread_name") {
      REQUIRE(names.emplace(e["tid"], e["args"]["name"]).second);
    }
  return names;
}

inline std::size_t count_events(const nlohmann::json& trace, const std::string& phase,
                                const std::string& name) {
  std::size_t count = 0;
  for (const auto& e : trace["traceEvents"]) count += e["ph"] == phase && e["name"] == name;
  return count;
}

/// The seconds that a node's spans of a name say were spent.
inline double busy_seconds(const nlohmann::json& trace, const std::string& node, const std::string& name) {
  const auto names = thread_names(trace);
  double sum = 0;
  for (const auto& e : trace["traceEvents"])
    if (e["ph"] == "X" && e["name"] == name && names.at(e["tid"]) == node)
      sum += e["args"].value("busy_us", e["dur"].get<double>()) * 1e-6;
  return sum;
}

/// Number of flows of a category; each has one start and one finish.
inline std::size_t flows(const nlohmann::json& trace, const std::string& category) {
  std::map<std::int64_t, std::pair<int, int>> ends;
  for (const auto& e : trace["traceEvents"]) {
    if (e.value("cat", "") != category || (e["ph"] != "s" && e["ph"] != "f")) continue;
    ++(e["ph"] == "s" ? ends[e["id"]].first : ends[e["id"]].second);
  }
  for (const auto& [id, count] : ends) {
    INFO(category << " " << id);
    REQUIRE(count == std::pair(1, 1));
  }
  return ends.size();
}

/// Spans of a row nest or lie apart, and every flow's end lies in one.
inline void check_row(const TraceEvents& row) {
  std::vector<std::int64_t> open;
  std::int64_t last = 0;
  for (const auto& e : row) {
    const std::int64_t begin = nanoseconds(e["ts"]);
    REQUIRE(begin >= last);
    last = begin;
    while (!open.empty() && open.back() <= begin && e["ph"] == "X") open.pop_back();
    if (e["ph"] == "X") {
      const std::int64_t end = begin + nanoseconds(e["dur"]);
      INFO(e.dump());
      REQUIRE(end >= begin);
      REQUIRE((open.empty() || end <= open.back()));
      open.push_back(end);
    } else if (e["ph"] == "s" || e["ph"] == "f") {
      INFO(e.dump());
      REQUIRE_FALSE(open.empty());
    }
  }
}

inline void check_trace(const nlohmann::json& trace, int gps, int renderers, int ranks) {
  REQUIRE(trace["displayTimeUnit"] == "ms");
  const std::set<std::string> known{"slice",        "wait for token", "send",       "draw",
                                    "composite",    "deliver",        "pass token", "take token",
                                    "send payload", "take payload"};
  const auto names = thread_names(trace);
  REQUIRE(names.size() == std::size_t(gps + renderers + 1));
  std::set<int> processes;
  std::map<int, int> process_of;
  std::map<int, TraceEvents> rows;
  for (const auto& e : trace["traceEvents"]) {
    if (e["ph"] == "M" && e["name"] == "process_name") processes.insert(e["pid"].get<int>());
    if (e["ph"] == "M") continue;
    INFO(e.dump());
    REQUIRE(names.count(e["tid"]) == 1);
    REQUIRE(process_of.emplace(e["tid"], e["pid"]).first->second == e["pid"]);
    REQUIRE(processes.count(e["pid"]) == 1);
    REQUIRE(e["args"]["frame"].is_number_integer());
    if (e["ph"] == "X") {
      REQUIRE(known.count(e["name"]) == 1);
      REQUIRE((e["name"] == "deliver" || e["args"]["step"].get<int>() >= 0));
    }
    rows[e["tid"]].push_back(e);
  }
  REQUIRE(processes.size() == std::size_t(ranks));
  for (const auto& [thread, row] : rows) {
    INFO(names.at(thread));
    check_row(row);
  }
}

}  // namespace ringsplat::test
