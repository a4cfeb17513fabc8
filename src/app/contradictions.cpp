#include <fmt/format.h>

#include <algorithm>

#include "app/option_values.hpp"
#include "app/options.hpp"
#include "app/text_output.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::app {
namespace {

struct Contradiction {
  const char *first, *second, *way_out;
};
constexpr Contradiction contradictions[] = {
    {"--orbit", "--path", "each says what all frames are: keep one"},
    {"--matrix", "--azimuth", "a matrix is the whole view: leave out the angle"},
    {"--matrix", "--elevation", "a matrix is the whole view: leave out the angle"},
    {"--matrix", "--roll", "a matrix is the whole view: leave out the angle"},
    {"--matrix", "--zoom", "a matrix is the whole view: scale its rows instead"},
    {"--matrix", "--orbit",
     "an orbit turns the azimuth: give --elevation, --roll and --zoom instead of a matrix"},
    {"--matrix", "--path", "a path gives each frame's view: put the matrix into its lines as JSON"},
    {"--path", "--azimuth", "the path gives each frame's azimuth: leave it out"},
    {"--path", "--elevation", "the path gives each frame's elevation: leave it out"},
    {"--mesh", "--gps", "the mesh says how many GPs there are: leave out --gps"},
    {"--mesh", "--send-ahead", "in a mesh tokens wait, so that payloads do not meet: leave out --send-ahead"},
    {"--progressive", "--undersample", "progressive pictures begin with 4 anyway: leave out --undersample"},
    {"--count-only", "--output", "nothing is drawn that could be written: leave out -o"},
    {"--count-only", "--error", "nothing is drawn whose error could be measured: leave out --error"},
    {"--count-only", "--max-error", "nothing is drawn that could have an error: leave out --max-error"},
    {"--presets", "volume", "the presets need no volume: ask for one thing at a time"},
    {"--presets", "--gps", "the presets need no volume: ask for one thing at a time"},
    {"--presets", "--ranks", "the presets need no volume: ask for one thing at a time"},
    {"--list", "name", "ask for the list, or make one volume of it"},
    {"--list", "list", "ask for the default list, or run one"},
    {"--list", "--output", "the list goes to standard output: redirect it"},
    {"--list", "--keep-images", "a list has no pictures: leave out --keep-images"},
    {"--machine", "--cores",
     "the machine's file says how many there are: change platform.hosts and .cores there"},
};

/// An option that does nothing unless one of others is given; only where the subcommand has one of those.
struct Need {
  const char* option;
  std::vector<const char*> needs;
  const char* way_out;
};
const Need needs[] = {
    {"--error-pixels", {"--error", "--max-error"}, "add --error method"},
    {"--error-seed", {"--error", "--max-error"}, "add --error method"},
    {"--prefilter", {"--undersample", "--progressive", "--max-error"}, "add --undersample 2"},
    {"--link-slots", {"--mesh"}, "add --topology mesh and --mesh"},
    {"--seed", {"--shuffle", "--max-delay"}, "add --shuffle; for the pixels of --error it is --error-seed"},
    {"--diff-scale", {"--diff"}, "add --diff FILE"},
    {"--cores", {"--ranks"}, "add --ranks N"},
    {"--machine", {"--ranks"}, "add --ranks N"},
};

/// What may not be "-", for which a file of that name would be made.
constexpr std::pair<const char*, const char*> files_only[] = {
    {"--output", "name a file"}, {"--diff", "name a file"}, {"--keep-images", "name a folder"}};

bool has(const CLI::App& app, const char* name) { return app.get_option_no_throw(name) != nullptr; }
bool given(const CLI::App& app, const char* name) {
  const auto* option = app.get_option_no_throw(name);
  return option != nullptr && option->count() > 0;
}
bool given_as(const CLI::App& app, const char* name, const std::string& value) {
  return given(app, name) && app.get_option(name)->results().front() == value;
}

void refuse_what_others_leave_without_effect(const CLI::App& app) {
  for (const Need& need : needs) {
    const auto& others = need.needs;
    if (!given(app, need.option) ||
        std::none_of(others.begin(), others.end(), [&](const char* other) { return has(app, other); }) ||
        std::any_of(others.begin(), others.end(), [&](const char* other) { return given(app, other); }))
      continue;
    throw InputError(fmt::format("{} has no effect without {}", need.option,
                                 joined({others.begin(), others.end()}, " or ")),
                     need.way_out);
  }
  if (has(app, "--ranks") && !given(app, "--ranks"))
    for (const auto* option : app.get_options())
      for (const char* heading : {"View", "Picture", "Shortcuts"})
        if (option->count() > 0 && option->get_group() == heading)
          throw InputError(fmt::format("{} has no effect without --ranks", option->get_name()),
                           "add --ranks N to predict the time of such a frame");
  if (given(app, "--phases") && !given_as(app, "--kernel", "texture"))
    throw InputError("--phases has no effect on kernels that are computed",
                     "leave out --phases or use --kernel texture");
  if (given(app, "--samples") && !given_as(app, "--image-plane", "slices"))
    throw InputError("--samples has no effect on the screen, whose pixels --size counts",
                     "leave out --samples or use --image-plane slices");
  if (!given_as(app, "--shading", "none")) return;
  for (const char* name : {"--light", "--ambient", "--diffuse", "--specular", "--exponent"})
    if (given(app, name))
      throw InputError(fmt::format("{} has no effect with --shading none", name),
                       fmt::format("leave out {} or use --shading phong", name));
}

}  // namespace

void refuse_contradictions(const CLI::App& app) {
  for (const auto& c : contradictions)
    if (given(app, c.first) && given(app, c.second))
      throw InputError(fmt::format("{} and {} contradict each other", app.get_option(c.first)->get_name(),
                                   app.get_option(c.second)->get_name()),
                       c.way_out);
  for (const auto* option : app.get_options())
    for (const auto& value : option->results())
      if (value.empty())
        throw InputError(fmt::format("{} is empty", option->get_name()), "give it a value or leave it out");
  refuse_what_others_leave_without_effect(app);
  for (const auto& [option, way_out] : files_only)
    if (given(app, option) && is_stdout(app.get_option(option)->results().front()))
      throw InputError(fmt::format("what {} names cannot go to standard output", option), way_out);
}

}  // namespace ringsplat::app
