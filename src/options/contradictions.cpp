#include "options/contradictions.hpp"

#include "options/options.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::app {
namespace {

using enum Relation;

/// Stands for every value of --channel that means several.
constexpr const char* several = "several";

const Some only_splats{{.option = {}, .mark = Mark::of_splats}};
constexpr const char* without_light =
    "--mode=mip --mode=attenuated --mode=minip --mode=mean --mode=sum --mode=surface --slice";
const Some only_sheets{{.option = {}, .mark = Mark::of_sheets}, {.option = "--samples", .value = "1.5"}};

const Rule all_rules[] = {
    {"--orbit", excludes, "--path", "each says what all frames are: keep one"},
    {"--frames", excludes, "--frame", "each says which volumes: keep one"},
    {"--frames", excludes, "more", "several volumes are a series already: leave out --frames"},
    {"--frames", excludes, "--trace --error --max-error --machine",
     "leave it out, or render one of the volumes by itself", "{0} renders many volumes, {1} is for one"},
    {"--matrix", excludes, "--azimuth --elevation --roll", "a matrix is the whole view: leave out the angle"},
    {"--matrix", excludes, "--zoom", "a matrix is the whole view: scale its rows instead"},
    {"--matrix", excludes, "--pan --projection --eye --target", "a matrix is the whole view: leave one out"},
    {"--eye", excludes, "--azimuth --elevation --roll --distance --orbit",
     "the eye's position is the whole view: leave one out"},
    {"--view", excludes, "--azimuth --elevation --matrix --eye --path",
     "each says from where the volume is seen: keep one"},
    {"--fit", excludes, "--matrix --distance", "they say how large the volume is shown: leave out --fit"},
    {"--annotate", needs, "--output", "add -o OUT.png"},
    {"--fov --distance", needs, "--projection=perspective", "add --projection perspective"},
    {"--up", needs, "--eye", "add --eye, or turn the picture by --roll"},
    {"--matrix", excludes, "--orbit",
     "an orbit turns the azimuth: give --elevation, --roll and --zoom instead of a matrix"},
    {"--matrix", excludes, "--path", "a path gives each frame's view: put the matrix into its lines as JSON"},
    {"--path", excludes, "--azimuth --elevation",
     "the path gives each frame's azimuth and elevation: leave them out"},
    {"--channel=several", excludes,
     "--trace --machine --error --max-error --values --colours --labels --tf-out",
     "leave it out, or draw one channel by itself", "{0} draws several channels, {1} is for one"},
    {"--mesh", excludes, "--gps", "the mesh says how many GPs there are: leave out --gps"},
    {"--mesh", needs, "--topology=mesh", "add --topology mesh, or leave it out",
     "{0} has no effect in a ring"},
    {"--routing=direct", needs, "--topology=mesh", "add --topology mesh and --mesh, or leave it out",
     "{0} has no effect in a ring"},
    {"--mesh", excludes, "--send-ahead",
     "in a mesh tokens wait, so that payloads do not meet: leave out --send-ahead"},
    {"--count-only", excludes, "--output --error --max-error",
     "nothing is drawn that could be written or have an error: leave them out"},
    {"--count-only", excludes, "--layers",
     "what layers take to send shows when they are drawn: leave one out"},
    {"--layers", excludes, without_light,
     "only light through the volume is composited from layers: leave out --layers"},
    {"--engine=splats", excludes, "--quality=draft --quality=normal --quality=best",
     "only --quality paper draws splats: leave one out"},
    {"--engine=sheets", excludes, "--quality=paper", "--quality paper draws splats: leave one out"},
    // Unless told otherwise, sheets are drawn.
    {only_splats, needs, "--engine=splats --quality=paper", "leave out {0} or use --quality paper",
     "{0} has no effect on sheets"},
    {only_sheets, excludes, "--engine=splats --quality=paper", "leave out {0} or use --quality best",
     "{0} has no effect on splats"},
    {"--presets", excludes, "volume --gps --ranks",
     "the presets need no volume: ask for one thing at a time"},
    {"--list", excludes, "name", "ask for the list, or make one volume of it"},
    {"--list", excludes, "--output", "the list goes to standard output: redirect it"},
    {"--machine", excludes, "--cores",
     "the machine's file says how many there are: change platform.hosts and .cores there"},
    {"=", refused, "", "give it a value or leave it out", "{0} is empty"},
    {"--error=analytic", refused, "",
     "use ringsplat reference --truth analytic --formula NAME, then ringsplat compare",
     "--error analytic needs a formula, which a picture's volume does not name"},
    {"--truth=analytic", needs, "--formula", "ringsplat synth --list says what there is",
     "--truth analytic needs --formula NAME"},
    {"--formula", needs, "--truth=analytic", "use --truth analytic",
     "--formula has no effect without --truth analytic"},
    {"--error-pixels --error-seed --error-map", needs, "--error --max-error", "add --error method"},
    {"--guarantee", needs, "--max-error", "add --max-error 1"},
    {"--guarantee", needs, "--error=certified", "only bounds prove anything: add --error certified"},
    {"--guarantee", excludes, "--error-pixels", "all pixels are proved: leave out --error-pixels"},
    {"--prefilter", needs, "--undersample --max-error", "add --undersample 2"},
    {"--link-slots", needs, "--mesh", "add --topology mesh and --mesh"},
    {"--voxel-weight", needs, "--count-only", "add --count-only, or leave it out",
     "--voxel-weight has no effect on pictures"},
    {"--diff-scale", needs, "--diff", "add --diff FILE"},
    {"--cores --machine", needs, "--ranks", "add --ranks N"},
    {"--materials", needs, "--channel=several", "add --channel all, or name several"},
    {"--materials", excludes, "--layers --mask-as=tint --mask-as=outline",
     "materials are drawn through the whole volume, in channels' colours: leave one out"},
    {without_light, excludes, "--materials", "only light through the volume is dimmed: leave one out"},
    {"--isovalue", needs, "--mode=surface", "add --mode surface"},
    {"--values", needs, "--mode --slice", "add --mode sum or another"},
    {"--values", excludes, "--mode=composite --depth", "use --depth alone, which keeps the colours"},
    {"--depth", excludes,
     "--channel=several --slice --truth=certified --truth=analytic --mode=mip --mode=attenuated --mode=minip "
     "--mode=mean --mode=sum",
     "depths are of light or a surface, and of one volume: leave one out"},
    {"--cut", excludes, "--slice --depth --values --mode=sum",
     "a cut shows values in colours, in a volume: leave one out"},
    {"--cut", excludes, "--truth=analytic --error --max-error",
     "the error of two frames is not measured: compare with reference --cut"},
    {without_light, excludes, "--tf2d", "only light through the volume goes by opacities: leave one out"},
    {"--mask-as", needs, "--mask", "name the segmentation by --mask FILE"},
    {"--mask-as=tint --mask-as=outline", excludes,
     "--channel=several --engine=splats --quality=paper --mode=mip --mode=attenuated --mode=minip "
     "--mode=mean --mode=sum --mode=surface --values",
     "only light through sheets, and slices, are tinted: leave one out"},
    {"--slice", excludes,
     "--clip --clip-plane --mode --view --azimuth --elevation --matrix --eye --target --projection --orbit "
     "--path",
     "leave one out: a slice is seen from straight before it, and by itself"},
    {"--values", excludes,
     "--tf --range --colours --log --opacity --background --annotate --error --max-error",
     "numbers have no colours: leave one out"},
    {without_light, excludes, "--engine=splats --quality=paper --labels --interpolation=nearest",
     "only sheets of interpolated values have other modes: leave one out"},
    {"--labels", excludes, "--tf --range --colours --log", "labels have colours of their own: leave one out"},
    {"@View @Picture @Colours @Shortcuts", needs, "--ranks",
     "add --ranks N to predict the time of such a frame"},
    {"--samples", needs, "--image-plane=slices --quality=draft --quality=normal",
     "leave out --samples or use --image-plane slices",
     "--samples has no effect on the screen, whose pixels --size counts"},
    {"--samples", excludes, "--image-plane=screen", "leave out --samples or use --image-plane slices",
     "--samples has no effect on the screen, whose pixels --size counts"},
    {"--slabs --light --light-points --ambient --diffuse --specular --exponent", excludes,
     "--mode=mip --mode=attenuated --mode=minip --mode=mean --mode=sum", "leave out {0}, or show light",
     "{0} has no effect where values are shown instead of light"},
    {"--light --light-points --ambient --diffuse --specular --exponent", excludes, "--shading=none",
     "leave out {0} or use --shading phong", "{0} has no effect with --shading none"},
    // "-" is standard output for texts only; these options would make a file of that name.
    {"--output=- --diff=-", refused, "", "name a file", "what {0} names cannot go to standard output"},
};

bool given(const Option& option, const Which& which) {
  const auto meant = [&](const std::string& word) {
    return word == *which.value || (*which.value == several && names_channels(word));
  };
  return means(which, option) && option.is_given() &&
         (!which.value || std::any_of(option.given.begin(), option.given.end(), meant));
}

/// The given option that matches `which`, or null.
const Option* find_given(const OptionList& list, const Which& which) {
  for (const Option& option : list)
    if (given(option, which)) return &option;
  return nullptr;
}

[[noreturn]] void refuse(const Rule& rule, const Option& option, const std::string& others) {
  const char* const usual =
      rule.relation == excludes ? "{0} and {1} contradict each other" : "{0} has no effect without {1}";
  throw InputError(
      fmt::format(fmt::runtime(rule.problem != nullptr ? rule.problem : usual), option.name(), others),
      fmt::format(fmt::runtime(rule.way_out), option.name()));
}

/// Throws InputError when `option`, which is given, breaks the rule.
void apply(const Rule& rule, const OptionList& list, const Option& option) {
  if (rule.relation == refused) refuse(rule, option, {});
  std::vector<std::string> names;
  bool one_given = false, one_there = false;
  for (const Which& other : rule.others) {
    const Option* const found = find_given(list, other);
    if (found != nullptr && rule.relation == excludes) refuse(rule, option, found->name());
    one_given = one_given || found != nullptr;
    one_there = one_there || has(list, other);
    names.push_back(other.option);
  }
  if (rule.relation == needs && one_there && !one_given) refuse(rule, option, joined(names, " or "));
}

}  // namespace

Some::Some(const char* words) {
  for (const std::string& word : detail::words_of(words)) {
    const auto equals = std::min(word.find('='), word.size());
    Which& which =
        emplace_back(word.starts_with('@') ? Which{{}, word.substr(1)} : Which{word.substr(0, equals)});
    if (equals < word.size()) which.value = word.substr(equals + 1);
  }
}

std::span<const Rule> rules() { return all_rules; }

void refuse_contradictions(const OptionList& list) {
  for (const Rule& rule : rules())
    for (const Which& which : rule.options)
      for (const Option& option : list)
        if (given(option, which)) apply(rule, list, option);
}

}  // namespace ringsplat::app
