#include "python/picture_options.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string_view>

#include "options/contradictions.hpp"
#include "options/option_tables.hpp"
#include "options/subcommands.hpp"
#include "program/launch.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::python {
namespace {

using app::RenderOptions;

/// Of the groups below: what writes files, draws films, or is another argument in Python.
constexpr std::string_view never[] = {"volume", "--output", "--stats", "--trace",
                                      "--axes", "--orbit",  "--path",  "--progressive"};
constexpr std::string_view not_in_sessions[] = {
    "--frame",      "--channel",   "--series",          "--dims",  "--type",
    "--endian",     "--offset",    "--spacing",         "--error", "--error-pixels",
    "--error-seed", "--max-error", "--threads-per-rank"};
constexpr std::string_view layout_names[] = {"--gps",      "--renderers", "--bundle", "--roles",
                                             "--topology", "--mesh",      "--routing"};

template <std::size_t count>
bool is_one_of(const CLI::Option& option, const std::string_view (&names)[count]) {
  return std::any_of(std::begin(names), std::end(names),
                     [&](std::string_view name) { return option.check_name(std::string(name)); });
}

template <class LeftOut>
void leave_out(CLI::App& app, const LeftOut& left_out) {
  for (CLI::Option* const option : app.get_options())
    if (left_out(*option)) app.remove_option(option);
}

void add_options(CLI::App& app, RenderOptions& o, From from) {
  app.set_help_flag();
  add_options(app, app::volume_options, o.volume);
  add_options(app, app::raw_options, o.volume);
  for (const auto* group :
       {&app::clip_options, &app::render_output_options, &app::camera_options, &app::view_options,
        &app::size_options, &app::colour_options, &app::method_options, &app::shading_options,
        &app::picture_options, &app::shortcut_options})
    add_options(app, *group, o);
  add_options(app, app::error_options, o.error);
  add_options(app, app::error_budget_options, o.budget);
  add_options(app, app::rank_options, o.run);
  leave_out(app, [&](const CLI::Option& option) {
    const bool of_ranks = option.get_group() == app::rank_options.heading;
    return is_one_of(option, never) || (of_ranks && !option.check_name("--threads-per-rank")) ||
           (from == From::session && is_one_of(option, not_in_sessions));
  });
}

void parse(CLI::App& app, std::vector<std::string> words) {
  std::reverse(words.begin(), words.end());  // as CLI11 takes them
  try {
    app.parse(words);
  } catch (const CLI::ParseError& e) {
    std::string text = e.what();
    std::replace(text.begin(), text.end(), '\n', ' ');
    throw InputError(text, "help(ringsplat.render) describes the options");
  }
  app::refuse_contradictions(app);
}

}  // namespace

RenderOptions parse_picture(const std::vector<std::string>& words, const std::vector<app::ViewAngles>& views,
                            From from) {
  RenderOptions o;
  CLI::App app("", "render");
  add_options(app, o, from);
  parse(app, words);
  o.views = views;
  app::settle_picture(app, o);
  o.run.transport = app::TransportChoice::loopback;
  return o;
}

Layout parse_layout(const std::vector<std::string>& words, bool over_mpi, int ranks) {
  if (words.empty()) return {.gps = ranks, .renderers = ranks, .placement = Placement::colocated};
  app::RunOptions o;
  CLI::App app("", "layout");
  app.set_help_flag();
  add_options(app, app::rank_options, o);
  leave_out(app, [](const CLI::Option& option) { return !is_one_of(option, layout_names); });
  parse(app, words);
  if (o.choose_roles)
    throw InputError("a session's roles cannot be chosen by a measured frame, as it has no volume yet",
                     "give numbers instead of auto");
  return app::choose_layout(o, over_mpi, over_mpi ? ranks : 1);
}

std::string picture_options_json() {
  RenderOptions o;
  CLI::App app("", "render");
  add_options(app, o, From::volume);
  auto list = nlohmann::json::array();
  for (const CLI::Option* option : app.get_options())
    list.push_back({{"name", option->get_lnames().front()},
                    {"form", option->get_type_name()},
                    {"default", option->get_default_str()},
                    {"help", option->get_description()},
                    {"group", option->get_group()},
                    {"values", option->get_items_expected_max()},
                    {"session", !is_one_of(*option, not_in_sessions)}});
  return list.dump();
}

}  // namespace ringsplat::python
