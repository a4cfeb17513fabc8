#include <algorithm>
#include <glm/gtc/type_ptr.hpp>
#include <glm/vector_relational.hpp>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "base/log.hpp"
#include "base/text.hpp"
#include "formats/channels.hpp"
#include "formats/formats.hpp"
#include "formats/limits.hpp"
#include "formats/stored_source.hpp"
#include "formats/text_reader.hpp"
#include "formats/volume_files.hpp"
#include "volume/forwarding_source.hpp"

namespace ringsplat::detail {
namespace {

constexpr const char* hint =
    "give a whole 3-D plotfile, or save a grid of it, as yt's covering_grid, as a .npy";

/// The text without brackets and commas, which AMReX puts around numbers.
std::string bare(std::string text) {
  std::ranges::replace_if(
      text, [](char c) { return c == '(' || c == ')' || c == ','; }, ' ');
  return one_line(text);
}

/// One of a plotfile's texts, line by line; each must be there.
class Lines {
 public:
  explicit Lines(const std::filesystem::path& path) : file_(path), text_(file_) {}

  [[noreturn]] void fail(const char* what) const {
    refuse(file_.path(), hint, "line {}, '{}', is not {}", number_, excerpt(line_), what);
  }
  const std::string& next(const char* what) {
    const auto line = text_.line();
    if (!line) refuse(file_.path(), hint, "it ends behind line {}, before {}", number_, what);
    ++number_;
    return line_ = trimmed(*line);
  }
  template <class T = int>
  std::vector<T> numbers(const char* what, std::size_t count, T most = std::numeric_limits<T>::max()) {
    auto list = mapped(words_of(bare(next(what))), [&](const std::string& word) {
      const auto number = number_in<T>(word);
      if (!number || !(*number >= -most && *number <= most)) fail(what);
      return *number;
    });
    if (list.size() != count) fail(what);
    return list;
  }
  int number(const char* what, int least, int most) {
    const int number = numbers(what, 1)[0];
    if (number < least || number > most) fail(what);
    return number;
  }
  const std::string& line() const { return line_; }  ///< the last one
 private:
  InputFile file_;
  TextReader text_;
  int number_ = 0;
  std::string line_;
};

/// A box of level 0: its first cell and the one behind its last, and where its values are.
struct Fab {
  glm::ivec3 first{0}, end{0};
  std::string words;  ///< of the line before the values: the box and the number of components
  std::filesystem::path file = {};
  std::uint64_t offset = 0;  ///< of that line

  /// The values of the first component, which others follow.
  StoredVoxels stored() const {
    // How many bits there are and what they are for, and the order of the bytes.
    constexpr const char* known[] = {"8 32 8 23 0 1 9 0 127 4 4 3 2 1", "8 32 8 23 0 1 9 0 127 4 1 2 3 4",
                                     "8 64 11 52 0 1 12 0 1023 8 8 7 6 5 4 3 2 1",
                                     "8 64 11 52 0 1 12 0 1023 8 1 2 3 4 5 6 7 8"};
    constexpr std::uint64_t longest = 1024;  // of such lines
    const InputFile input(file);
    require_bytes(file, input.size(), offset, 1);
    TextReader text(input, offset, offset + longest);
    const auto line = bare(text.line().value_or(""));
    for (int i = 0; i < 4; ++i)
      if (line == fmt::format("FAB {} {}", known[i], words))
        return {.file = file,
                .offset = text.position(),
                .big_endian = i % 2 != 0,
                .type = i < 2 ? ScalarType::float32 : ScalarType::float64};
    refuse(file, hint, "at byte {} is '{}' where float32 or float64 values of the box {} belong", offset,
           excerpt(line), words);
  }
};

/// The first of `count` boxes in a line.
Fab read_box(Lines& lines, std::size_t count = 1) {
  constexpr int most = 1 << 29;  // sizes stay within int
  const auto n = lines.numbers("boxes of cells", 9 * count, most);
  const Fab box{glm::make_vec3(n.data()), glm::make_vec3(n.data() + 3) + 1, bare(lines.line())};
  if (!glm::all(glm::lessThan(box.first, box.end)) || std::count(n.begin() + 6, n.begin() + 9, 0) != 3)
    lines.fail("boxes of cells");
  return box;
}

std::vector<Fab> read_fabs(const std::filesystem::path& path, const Fab& domain, int channels) {
  Lines lines(path);
  lines.number("version 1, whose boxes describe themselves", 1, 1);
  lines.next("a number of files");
  lines.number("Header's number of components", channels, channels);
  if (const auto ghosts = bare(lines.next("ghost cells")); ghosts != "0" && ghosts != "0 0 0")
    lines.fail("0, for boxes without ghost cells");
  const int count = lines.numbers("a number of boxes up to 65536", 2, int(most_pieces))[0];
  std::vector<Fab> fabs;
  for (int i = 0; i < count; ++i) {
    auto fab = read_box(lines);
    if (glm::min(fab.first, domain.first) != domain.first || glm::max(fab.end, domain.end) != domain.end)
      lines.fail("a box within the domain");
    fab.words += fmt::format(" {}", channels);
    fabs.push_back(std::move(fab));
  }
  lines.next("the boxes' end");
  lines.number("the number of boxes", std::max(count, 1), count);
  for (auto& fab : fabs) {
    const auto words = words_of(lines.next("the boxes' files"));
    const auto offset = number_in<std::uint64_t>(words.size() == 3 ? words[2] : "");
    if (!offset || words[1] != std::filesystem::path(words[1]).filename())
      lines.fail("a box's file beside this one, and an offset");
    fab.file = path.parent_path() / words[1];
    fab.offset = *offset;
  }
  return fabs;
}

}  // namespace

std::unique_ptr<VolumeSource> open_amrex(const std::filesystem::path& path, const VolumeChoice& choice) {
  constexpr int most_channels = 100'000, most_levels = 100;
  Lines lines(path / "Header");
  if (const auto& kind = lines.next("its version"); kind.starts_with("Check") || kind.starts_with("Version_"))
    refuse(path, hint, "it holds a checkpoint or particles, '{}'", excerpt(kind));
  VolumeNotes notes{.channels = lines.number("a number of components", 1, most_channels)};
  for (int c = 0; c < notes.channels; ++c)
    notes.of_channels.push_back({.name = lines.next("the components' names")});
  lines.number("3, the dimensions of a volume", 3, 3);
  lines.next("the time");
  const int finest = lines.number("the finest level's number", 0, most_levels);
  Grid grid{.origin = glm::make_vec3(lines.numbers<double>("the domain's corner", 3).data())};
  for (const char* what : {"the domain's other corner", "the levels' ratios"}) lines.next(what);
  const Fab domain = read_box(lines, std::size_t(finest) + 1);
  lines.next("the levels' steps");
  grid.dims = domain.end - domain.first;
  grid.spacing = glm::make_vec3(lines.numbers<double>("the size of cells", 3).data());
  grid.origin += 0.5 * grid.spacing;
  for (int level = 1; level <= finest; ++level) lines.next("the size of cells");
  lines.number("0, for Cartesian coordinates", 0, 0);

  const auto fabs = read_fabs(path / "Level_0/Cell_H", domain, notes.channels);
  grid.type = fabs.front().stored().type;
  check_lattice(grid, path.string());
  std::int64_t channel = 0;
  if (notes.channels > 1)
    channel = choose_named_channel(choice.channel, notes.channels, notes.of_channels, path.string());
  std::vector<VolumePiece> pieces;
  for (const Fab& fab : fabs) {
    const auto first = fab.first - domain.first;
    pieces.push_back({fab.file, {first, fab.end - domain.first}, first, [=, channels = notes.channels] {
                        auto stored = fab.stored();
                        if (stored.type != grid.type) refuse(fab.file, hint, "its boxes are of two types");
                        Grid box = grid;
                        box.dims = fab.end - fab.first;
                        stored.choose(box.bytes(), channels, channel);
                        return stored_source(box, {stored});
                      }});
  }
  if (finest > 0)
    log_line_once(LogLevel::info,
                  fmt::format("{}: level 0 of {} is shown, the coarsest", path.string(), finest + 1));
  notes.quantity = notes.of_channels[std::size_t(channel)].name;
  return with_notes(pieced_source(grid, std::move(pieces), path.string()), notes);
}

}  // namespace ringsplat::detail
