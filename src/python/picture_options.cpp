#include "python/picture_options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "options/contradictions.hpp"
#include "options/option_tables.hpp"
#include "program/launch.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::python {
namespace {

using app::Option;
using app::OptionList;
using app::RenderOptions;

OptionList options_for(RenderOptions& o, From from) {
  OptionList list;
  if (from == From::volume) {
    app::add_volume_options(list, o.volume);
    app::add_raw_options(list, o.volume);
  }
  for (const auto add : {app::add_clip_options, app::add_render_output_options, app::add_camera_options,
                         app::add_view_options, app::add_size_options, app::add_method_options,
                         app::add_shading_options, app::add_picture_options, app::add_shortcut_options})
    add(list, o);
  if (from == From::volume) {
    app::add_error_options(list, o);
    app::add_rank_options(list, o.run);
  }
  list.leave_out(app::Mark::of_program);
  return list;
}

InputError unexpected(const std::string& what) {
  return {what, "help(ringsplat.render) describes the options"};
}

/// "--name", "--name=value" or "--name=value" and further words of the value.
void read(OptionList& list, const app::Words& words) {
  for (std::size_t k = 0; k < words.size();) {
    const auto equals = words[k].find('=');
    const std::string name = words[k].substr(0, equals);
    const auto option =
        std::find_if(list.begin(), list.end(), [&](const Option& o) { return o.has_name(name); });
    if (option == list.end()) throw unexpected(fmt::format("'{}' is not expected here", words[k]));
    app::Words given{equals == std::string::npos ? "true" : words[k].substr(equals + 1)};
    for (++k; k < words.size() && !words[k].starts_with("--"); ++k) given.push_back(words[k]);
    const std::size_t wanted = option->is_flag() ? 1 : std::size_t(option->reader.words);
    if (given.size() != wanted)
      throw unexpected(fmt::format("{} needs {} values, not {}", name, wanted, given.size()));
    option->given = given;
  }
  list.read();
  refuse_contradictions(list);
}

}  // namespace

RenderOptions parse_picture(const std::vector<std::string>& words, const std::vector<app::ViewAngles>& views,
                            From from) {
  RenderOptions o;
  OptionList list = options_for(o, from);
  read(list, words);
  o.views = views;
  app::settle_picture(list, o);
  o.run.transport = app::TransportChoice::loopback;
  return o;
}

Layout parse_layout(const std::vector<std::string>& words, bool over_mpi, int ranks) {
  if (words.empty()) return {.gps = ranks, .renderers = ranks, .placement = Placement::colocated};
  app::RunOptions o;
  OptionList list;
  app::add_layout_options(list, o);
  read(list, words);
  if (o.choose_roles)
    throw InputError("a session's roles cannot be chosen by a measured frame, as it has no volume yet",
                     "give numbers instead of auto");
  return app::choose_layout(o, over_mpi, over_mpi ? ranks : 1);
}

std::string picture_options_json() {
  RenderOptions o;
  const OptionList in_sessions = options_for(o, From::session);
  auto list = nlohmann::json::array();
  for (const Option& option : options_for(o, From::volume))
    list.push_back({{"name", option.name().substr(2)},
                    {"form", option.form},
                    {"default", option.fallback},
                    {"help", option.help},
                    {"group", option.heading},
                    {"values", option.reader.words},
                    {"session", in_sessions.find(option.name()) != nullptr}});
  return list.dump();
}

}  // namespace ringsplat::python
