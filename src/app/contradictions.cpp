#include <fmt/format.h>

#include "app/options.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::app {

void refuse_contradictions(const CLI::App& app) {
  struct Contradiction {
    const char *first, *second, *way_out;
  };
  static constexpr Contradiction contradictions[] = {
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
      {"--mesh", "--send-ahead",
       "in a mesh tokens wait, so that payloads do not meet: leave out --send-ahead"},
      {"--progressive", "--undersample", "progressive pictures begin with 4 anyway: leave out --undersample"},
      {"--count-only", "--output", "nothing is drawn that could be written: leave out -o"},
      {"--presets", "--gps", "the presets need no volume: ask for one thing at a time"},
      {"--tf-out", "--ranks", "a prediction writes no file: use ringsplat render --tf-out"},
      {"--presets", "--ranks", "the presets need no volume: ask for one thing at a time"},
  };
  const auto given = [&](const char* name) {
    const auto* option = app.get_option_no_throw(name);
    return option != nullptr && option->count() > 0;
  };
  for (const auto& c : contradictions)
    if (given(c.first) && given(c.second))
      throw InputError(fmt::format("{} and {} contradict each other", c.first, c.second), c.way_out);
  if (app.get_option_no_throw("--ranks") != nullptr && !given("--ranks"))
    for (const auto* option : app.get_options())
      for (const char* heading : {"View", "Picture", "Shortcuts"})
        if (option->count() > 0 && option->get_group() == heading)
          throw InputError(fmt::format("{} has no effect without --ranks", option->get_name()),
                           "add --ranks N to predict the time of such a frame");
  const auto* kernel = app.get_option_no_throw("--kernel");
  if (given("--phases") && (kernel->count() == 0 || kernel->results().front() != "texture"))
    throw InputError("--phases has no effect on kernels that are computed",
                     "leave out --phases or use --kernel texture");
  const auto* plane = app.get_option_no_throw("--image-plane");
  if (given("--samples") && (plane->count() == 0 || plane->results().front() != "slices"))
    throw InputError("--samples has no effect on the screen, whose pixels --size counts",
                     "leave out --samples or use --image-plane slices");
  if (given("--cores") && !given("--ranks"))
    throw InputError("--cores has no effect without --ranks", "add --ranks N");
  if (given("--machine") && app.get_option_no_throw("--ranks") != nullptr && !given("--ranks"))
    throw InputError("--machine has no effect without --ranks", "add --ranks N");
  if (given("--machine") && given("--cores"))
    throw InputError("--cores has no effect with --machine, whose file says how many there are",
                     "change platform.hosts and .cores there");
  const auto* shading = app.get_option_no_throw("--shading");
  if (shading == nullptr || shading->count() == 0 || shading->results().front() != "none") return;
  for (const char* name : {"--light", "--ambient", "--diffuse", "--specular", "--exponent"})
    if (given(name))
      throw InputError(fmt::format("{} has no effect with --shading none", name),
                       fmt::format("leave out {} or use --shading phong", name));
}

}  // namespace ringsplat::app
