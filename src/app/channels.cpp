#include "app/channels.hpp"

#include "formats/channels.hpp"

namespace ringsplat::app {
namespace {

using Colour = std::optional<glm::dvec3>;

constexpr std::size_t most_channels = 6;

/// napari's, in its order for three channels and more. Green is the display's own, not CSS's darker one.
const std::pair<const char*, glm::dvec3> usual_colours[] = {{"cyan", {0, 1, 1}},   {"magenta", {1, 0, 1}},
                                                            {"yellow", {1, 1, 0}}, {"blue", {0, 0, 1}},
                                                            {"green", {0, 1, 0}},  {"red", {1, 0, 0}}};

Colour colour_named(const std::string& text) {
  if (const Colour colour = detail::found(usual_colours, text)) return colour;
  if (text.starts_with('#'))
    if (const Colour colour = hex_colour(text.substr(1))) return colour;
  const auto light = parse_colour(text, "--channel");
  return light ? Colour(linear_to_srgb(*light)) : Colour();
}

glm::dvec3 usual_colour(const std::string& channel, std::size_t number, std::size_t channels) {
  for (const char* const colour : {"red", "green", "blue"})
    if (channel == std::string(1, *colour)) return *colour_named(colour);
  if (channels == 1) return glm::dvec3(1);
  if (channels == 2) return *colour_named(number == 0 ? "magenta" : "green");
  return usual_colours[number].second;
}

/// What "all" means: the channels that the file's programs show.
std::vector<std::string> shown_channels(const VolumeNotes& notes) {
  std::vector<std::string> shown, all;
  for (std::size_t c = 0; c < std::size_t(notes.channels); ++c) {
    all.push_back(std::to_string(c));
    if (c >= notes.of_channels.size() || !notes.of_channels[c].hidden) shown.push_back(all.back());
  }
  return shown.empty() ? all : shown;
}

/// Where a file has one colour for all of several channels, no program has chosen it.
void leave_out_same_colours(std::vector<ChannelNotes>& channels) {
  const bool same = std::ranges::all_of(
      channels, [&](const ChannelNotes& channel) { return channel.colour == channels.front().colour; });
  for (ChannelNotes& channel : channels)
    if ((same && channels.size() > 1) || channel.colour == glm::dvec3(0)) channel.colour.reset();
}

}  // namespace

std::vector<DrawnChannel> find_channels(VolumeOptions volume, const std::string& wanted) {
  auto words = detail::mapped(split(wanted, ","), detail::trimmed);
  const auto open = [&](const std::string& word) {
    volume.choice.channel = word.substr(0, word.find('='));
    return open_volume(volume)->notes();
  };
  const VolumeNotes notes = open(words.front());
  if (wanted == "all" && notes.channels == 1) return {};
  if (notes.channels == 1)  // of a volume that is no file
    throw InputError(fmt::format("--channel {}: {} has one value a voxel", wanted, volume.path),
                     "leave --channel out");
  if (wanted == "all") words = shown_channels(notes);
  if (words.size() > most_channels)
    throw InputError(
        fmt::format("--channel {}: {} channels are too many for one picture", wanted, words.size()),
        fmt::format("name at most {}, such as 0,1,2", most_channels));
  std::vector<ChannelNotes> said;
  std::vector<DrawnChannel> channels;
  std::set<std::int64_t> taken;
  for (const std::string& word : words) {
    open(word);  // it says which channels there are where this is none
    DrawnChannel& channel = channels.emplace_back();
    channel.choice = volume.choice.channel;
    const auto index = detail::find_channel(channel.choice, notes.channels, notes.of_channels);
    if (index && !taken.insert(*index).second)
      throw InputError(fmt::format("--channel {}: channel {} is there twice", wanted, channel.choice),
                       "name each once");
    const bool known = index && std::size_t(*index) < notes.of_channels.size();
    said.push_back(known ? notes.of_channels[std::size_t(*index)] : ChannelNotes{});
    channel.name = said.back().name.empty() ? "channel " + channel.choice : excerpt(said.back().name);
    channel.window = said.back().window;
  }
  leave_out_same_colours(said);
  for (std::size_t k = 0; k < words.size(); ++k) {
    const auto equals = words[k].find('=');
    const Colour given =
        equals < words[k].size() ? colour_named(words[k].substr(equals + 1)) : said[k].colour;
    channels[k].colour = given.value_or(usual_colour(channels[k].choice, k, words.size()));
  }
  return channels;
}

MadeFunction make_function(DrawnChannel& channel, const RenderOptions& options, const ValueStatistics& values,
                           Shown& shown) {
  ColourOptions colour = options.colour;
  colour.tint = channel.colour;
  // Means and integrals of values are others than the values that the window is for.
  const bool of_values = colour.mode != Mode::mean && colour.mode != Mode::sum;
  if (!colour.range && channel.window && of_values) colour.range = {channel.window->x, channel.window->y};
  MadeFunction made = TransferFunctionChoice(options.transfer_function, colour).make(values, shown);
  channel.function = shown.transfer_function;
  const auto& ends = channel.function.colours;
  const glm::ivec3 rgb(255.0 * channel.colour + 0.5);
  made.said =
      fmt::format("{} ({}): #{:02x}{:02x}{:02x}, values from {:.4g} to {:.4g}", channel.name, channel.choice,
                  rgb.x, rgb.y, rgb.z, plain(ends.front().value), plain(ends.back().value));
  return made;
}

}  // namespace ringsplat::app
