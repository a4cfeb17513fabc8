#include "simulate/machine.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <fstream>
#include <functional>
#include <set>
#include <sstream>
#include <vector>

#include "ringsplat/base/error.hpp"

namespace ringsplat {
namespace {

constexpr std::array names{"backbone", "mesh", "torus", "fat_tree"};  // in PlatformKind's order

/// One number of the file: where it goes and what it may be.
struct Field {
  const char* key;
  double least, most;
  std::function<void(double)> set;
  bool required = false, whole = false;
  /// A cost of sheets in costs of a splat, where the file does not say it: about their ratio where both were
  /// measured (mpi_configs/machines/two-core.toml).
  double in_splats = 0;
};

constexpr double no_limit = 1e300;

template <class T>
std::function<void(double)> into(T& target) {
  return [&target](double value) { target = static_cast<T>(value); };
}

std::vector<Field> fields_of(Machine& m) {
  constexpr double longest = 3600, most_count = 1 << 20;
  const auto seconds = [](const char* key, double& target, bool required = false, double in_splats = 0) {
    return Field{key, 0, longest, into(target), required, false, in_splats};
  };
  const auto count = [](const char* key, auto& target, double least, double most) {
    return Field{key, least, most, into(target), false, true};
  };
  return {seconds("gp.visible_voxel", m.gp.visible_voxel, true),
          seconds("gp.transparent_voxel", m.gp.transparent_voxel, true),
          seconds("gp.slice", m.gp.slice),
          seconds("gp.frame", m.gp.frame),
          seconds("gp.token", m.gp.token),
          seconds("renderer.splat", m.renderer.splat, true),
          seconds("renderer.pass", m.renderer.pass),
          seconds("renderer.slice", m.renderer.slice),
          seconds("renderer.composite", m.renderer.composite),
          seconds("renderer.pixel", m.renderer.pixel),
          seconds("renderer.frame", m.renderer.frame),
          seconds("sheets.look", m.sheets.look, false, 0.05),
          seconds("sheets.copy", m.sheets.copy, false, 1.0),
          seconds("sheets.place", m.sheets.place, false, 2),
          seconds("sheets.slice", m.sheets.slice, false, 100),
          seconds("sheets.sample", m.sheets.sample, false, 0.1),
          seconds("sheets.table", m.sheets.table, false, 2e4),
          seconds("message.send", m.message.send),
          seconds("message.receive", m.message.receive),
          seconds("message.wake", m.message.wake),
          seconds("message.packet", m.message.packet),
          count("message.packet_bytes", m.message.packet_bytes, 0, 1 << 30),
          count("slow.rank", m.slow.rank, -1, most_count),
          {"slow.factor", 1, 1000, into(m.slow.factor)},
          {"poll_interval", 1e-9, longest, into(m.poll_interval), true},
          {"platform.bandwidth", 1, no_limit, into(m.platform.bandwidth), true},
          seconds("platform.latency", m.platform.latency, true),
          {"platform.backbone_bandwidth", 0, no_limit, into(m.platform.backbone_bandwidth)},
          {"platform.local_bandwidth", 0, no_limit, into(m.platform.local_bandwidth)},
          seconds("platform.local_latency", m.platform.local_latency),
          count("platform.cores", m.platform.cores, 1, most_count),
          count("platform.hosts", m.platform.hosts, 0, most_count),
          count("platform.leaf", m.platform.leaf, 1, most_count)};
}

constexpr const char* hint = "mpi_configs/machines has machines that work, docs/simulation.md the fields";

std::vector<CLI::ConfigItem> items_of(const std::string& toml, const std::string& where) {
  std::istringstream in(toml);
  try {
    return CLI::ConfigTOML().from_config(in);
  } catch (const CLI::Error& e) {
    throw InputError(fmt::format("{} is no TOML: {}", where, e.what()), hint);
  }
}

}  // namespace

const char* name(PlatformKind kind) { return names[std::size_t(kind)]; }

Machine parse_machine(const std::string& toml, const std::string& where) {
  Machine machine;
  const std::vector<Field> fields = fields_of(machine);
  std::set<std::string> seen;
  const auto require = [&](const std::string& key, bool right, const std::string& problem) {
    if (!right) throw InputError(fmt::format("{}: {} {}", where, key, problem), hint);
  };
  for (const auto& item : items_of(toml, where)) {
    if (item.name == "++" || item.name == "--") continue;  // CLI11's marks of a section's begin and end
    const std::string key = item.fullname();
    seen.insert(key);
    require(key, item.inputs.size() == 1, "needs one value");
    const std::string& text = item.inputs.front();
    if (key == "name") {
      machine.name = text;
    } else if (key == "platform.kind") {
      const auto kind = std::find(names.begin(), names.end(), text);
      require(key, kind != names.end(),
              "is '" + text + "', none of " + fmt::to_string(fmt::join(names, ", ")));
      machine.platform.kind = PlatformKind(kind - names.begin());
    } else {
      const auto field = std::ranges::find_if(fields, [&](const Field& f) { return key == f.key; });
      require(key, field != fields.end(), "is no field of a machine");
      double value = 0;
      require(key, CLI::detail::lexical_cast(text, value) && std::isfinite(value),
              fmt::format("is '{}', not a number", text));
      require(key, !field->whole || value == std::floor(value),
              fmt::format("is {}, not a whole number", text));
      require(key, value >= field->least && value <= field->most,
              field->most < no_limit
                  ? fmt::format("is {}, not from {} to {}", text, field->least, field->most)
                  : fmt::format("is {}, below {}", text, field->least));
      field->set(value);
    }
  }
  for (const Field& field : fields) {
    require(field.key, !field.required || seen.contains(field.key), "is missing");
    if (field.in_splats > 0 && !seen.contains(field.key)) field.set(field.in_splats * machine.renderer.splat);
  }
  for (const char* key : {"name", "platform.kind"}) require(key, seen.contains(key), "is missing");
  return machine;
}

Machine read_machine(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  if (!in || !(text << in.rdbuf()))
    throw InputError(fmt::format("the machine {} cannot be read", path),
                     "name a file such as mpi_configs/machines/pixel-planes-5.toml");
  return parse_machine(text.str(), path);
}

}  // namespace ringsplat
